"""Seeded worlds with furniture and walkers, each with a goal that is proven to be reachable.

The robot starts at the origin, arm ready. The goal is the tool pose of a stance that the judge
finds free with a margin, and to which `Paths` has found a path.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from pinocchio import SE3

from controller import Array, RobotModel, Surroundings
from lab.bench.contacts import ContactChecker
from lab.bench.motion_evaluation import Evaluator
from lab.bench.obstacles.contact_judge import Judge
from lab.bench.obstacles.obstacle_furniture import (
    TABLE_HEIGHT,
    placed,
    pose,
    random_furniture,
    random_object,
    shelf,
    table,
    walls,
)
from lab.bench.obstacles.reachability import STANCE_MARGIN, Paths, Stance, draw_postures, stance_at
from lab.bench.obstacles.walkers import Walker
from robots import Cylinder, Geom, half_extents

FAMILIES = ("room", "shelf", "table", "walkers")

_START_MARGIN = 0.05  # least distance of obstacles to the robot at its start [m]
_LEAST_MANIPULABILITY = 0.03  # of the arm at the goal
_CANDIDATES = 64  # number of stances that are drawn before the world is drawn anew
_WALKER_TRIES = 60
_FAR = 2.6  # least distance of goals behind walkers from the start [m]
_ASIDE = 0.24  # least distance of walkers from the robot at its start and at its stance [m]

_Draft: TypeAlias = tuple[list[Geom], Callable[[], Stance | None]]
"""Furniture, and a function that draws stances with goals on it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class World:
    """The obstacles around the robot, and its goal."""

    family: str
    number: int
    fixtures: tuple[Geom, ...]
    walkers: tuple[Walker, ...]
    goal: SE3  # the tool in the world
    stance: Stance  # a stance with the tool at the goal

    def surroundings(self, time: float) -> Surroundings:
        """As given to the controller at a time since the start [s]."""
        moving = tuple(walker.obstacle(time) for walker in self.walkers)
        return Surroundings(fixtures=self.fixtures, moving=moving)


class WorldMaker:
    """Makes worlds for one robot."""

    def __init__(self, model: RobotModel) -> None:
        self._model = model
        self._ready = model.description.arm.ready
        self._judge = Judge(model.description)
        self._checker = ContactChecker(model)
        self._manipulability = Evaluator(model).manipulability
        self._any = draw_postures(model, self._checker)
        self._down, self._slanted = self._any.down, self._any.slanted

    def __call__(self, family: str, number: int, seed: int) -> World:
        """The world of this number; always the same for a seed."""
        rng = np.random.default_rng((seed, FAMILIES.index(family), number))
        draft = {
            "room": self._room,
            "shelf": self._shelf,
            "table": self._table,
            "walkers": self._open,
        }[family]
        while True:
            fixtures, draw = draft(rng)
            stance = self._reachable(fixtures, draw)
            if stance is None:
                continue
            walkers = list(self._walkers(rng, fixtures, stance)) if family == "walkers" else []
            if family == "walkers" and not walkers:
                continue
            return World(
                family=family,
                number=number,
                fixtures=tuple(fixtures),
                walkers=tuple(walkers),
                goal=self._model.end_effector(pose(stance.base[:2], stance.base[2]), stance.q),
                stance=stance,
            )

    def _reachable(self, fixtures: list[Geom], draw: Callable[[], Stance | None]) -> Stance | None:
        start = self._judge.clearances(np.zeros((1, 3)), self._ready[None], fixtures)[0]
        if start < _START_MARGIN:
            return None
        paths = Paths(self._model, self._judge, self._checker, fixtures)
        if not paths.start_is_free:
            return None
        drawn = [stance for _ in range(_CANDIDATES) if (stance := draw()) is not None]
        if not drawn:
            return None
        base, q = (np.array(values) for values in zip(*drawn, strict=True))
        clear = self._judge.clearances(base, q, fixtures)
        for stance in (drawn[number] for number in np.flatnonzero(clear > STANCE_MARGIN)):
            dexterous = self._manipulability(stance.q) > _LEAST_MANIPULABILITY
            if dexterous and paths.reaches(*stance):
                return stance
        return None

    def _room(self, rng: np.random.Generator) -> _Draft:
        low, high = rng.uniform(-3.5, -1.5, 2), rng.uniform(1.5, 3.5, 2)
        turn = pose(np.zeros(2), rng.uniform(-np.pi, np.pi))
        pieces = [
            placed(random_furniture(f"{number}", rng), turn * self._place(rng, low, high))
            for number in range(1, rng.integers(6, 12))
        ]
        fixtures = placed(walls(low, high), turn) + [part for parts in pieces for part in parts]

        def draw() -> Stance | None:
            near = pieces[rng.integers(len(pieces))][0]
            half = np.array(half_extents(near.shape))
            if rng.random() < 0.5:
                x, y = rng.uniform(-half[:2], half[:2])
                point = near.pose.act(np.array([x, y, half[2] + rng.uniform(0.06, 0.30)]))
            else:
                aside = rng.uniform(-half[:2] - 0.35, half[:2] + 0.35)
                point = near.pose.act(np.array([*aside, 0.0]))
                point[2] = rng.uniform(0.15, 1.3)
            return stance_at(rng, self._any, point)

        return fixtures, draw

    def _shelf(self, rng: np.random.Generator) -> _Draft:
        boards = [float(rng.uniform(0.05, 0.45))]
        while boards[-1] < 1.3:
            boards.append(boards[-1] + float(rng.uniform(0.32, 0.48)))
        width, depth = rng.uniform((0.8, 0.28), (1.4, 0.40))
        mTs = self._place(rng, np.full(2, -2.8), np.full(2, 2.8))
        fixtures = placed(shelf("shelf", float(width), float(depth), boards), mTs)
        fixtures += self._scattered(rng, int(rng.integers(0, 4)))
        yaw = float(np.arctan2(mTs.rotation[1, 0], mTs.rotation[0, 0]))

        def draw() -> Stance | None:
            level = rng.integers(len(boards) - 1)
            x = -depth / 2.0 + rng.uniform(0.02, depth - 0.08)
            y = rng.uniform(-0.5, 0.5) * (width - 0.24)
            z = rng.uniform(boards[level] + 0.09, boards[level + 1] - 0.07)
            point = mTs.act(np.array([x, y, z]))
            return stance_at(rng, self._slanted, point, yaw + rng.uniform(-0.6, 0.6))

        return fixtures, draw

    def _table(self, rng: np.random.Generator) -> _Draft:
        (length, width), height = rng.uniform((0.8, 0.6), (1.6, 0.9)), rng.uniform(*TABLE_HEIGHT)
        mTt = self._place(rng, np.full(2, -2.8), np.full(2, 2.8))
        half = np.array([width, length]) / 2.0 - 0.05
        objects = [
            random_object(f"object{number}", rng).moved(
                pose(rng.uniform(-half, half), rng.uniform(-np.pi, np.pi), height)
            )
            for number in range(1, rng.integers(4, 9))
        ]
        fixtures = placed(table("table", length, width, height) + objects, mTt)
        fixtures += self._scattered(rng, int(rng.integers(0, 4)))

        def draw() -> Stance | None:
            x, y = rng.uniform(-half, half)
            point = mTt.act(np.array([x, y, height + rng.uniform(0.04, 0.25)]))
            return stance_at(rng, self._down, point)

        return fixtures, draw

    def _open(self, rng: np.random.Generator) -> _Draft:
        def draw() -> Stance | None:
            bearing, distance = rng.uniform(-np.pi, np.pi), rng.uniform(_FAR, 4.0)
            x, y = distance * np.cos(bearing), distance * np.sin(bearing)
            stance = stance_at(rng, self._any, np.array([x, y, rng.uniform(0.2, 1.2)]))
            far = stance is not None and np.hypot(*stance.base[:2]) > _FAR
            return stance if far else None

        return self._scattered(rng, int(rng.integers(0, 4))), draw

    def _scattered(self, rng: np.random.Generator, count: int) -> list[Geom]:
        low, high = np.full(2, -3.0), np.full(2, 3.0)
        return [
            part
            for number in range(1, count + 1)
            for part in placed(random_furniture(f"{number}", rng), self._place(rng, low, high))
        ]

    def _place(self, rng: np.random.Generator, low: Array, high: Array) -> SE3:
        """A random pose in a rectangle, away from the start."""
        place = rng.uniform(low, high)
        while np.hypot(*place) < 0.8:
            place = rng.uniform(low, high)
        return pose(place, rng.uniform(-np.pi, np.pi))

    def _walkers(
        self, rng: np.random.Generator, fixtures: list[Geom], stance: Stance
    ) -> Iterator[Walker]:
        """One or two that cross the straight line to the stance, away from both of its ends."""
        wanted = rng.integers(1, 3)
        for _ in range(_WALKER_TRIES):
            if not wanted:
                return
            walker = _draw_walker(rng, f"walker{wanted}", stance.base[:2])
            times = np.arange(0.0, 12.0, 0.05) / walker.speed
            where = walker.positions(times)
            if not _walks_free(walker, where, fixtures):
                continue
            ends = ((np.zeros(3), self._ready), stance)
            if all(self._is_aside(walker, times, *end) for end in ends):
                wanted -= 1
                yield walker

    def _is_aside(self, walker: Walker, times: Array, base: Array, q: Array) -> bool:
        bases, postures = (np.broadcast_to(a, (len(times), len(a))) for a in (base, q))
        clear = self._judge.walker_clearances(bases, postures, walker, times)
        return bool(clear.min() > _ASIDE)


def _draw_walker(rng: np.random.Generator, name: str, goal: Array) -> Walker:
    """A walker that nearly meets a robot which drives straight to its stance."""
    share, speed = rng.uniform(0.3, 0.7), float(rng.uniform(0.3, 1.0))
    radius = float(rng.uniform(0.2, 0.3))
    across = np.arctan2(goal[1], goal[0]) + rng.choice([-1.0, 1.0]) * rng.uniform(0.9, 2.2)
    direction = np.array([np.cos(across), np.sin(across)])
    crossing = share * goal
    if rng.random() < 0.5:
        meeting = np.hypot(*crossing) / 0.7 + rng.uniform(-1.0, 1.5)
        start, length, phase = crossing - direction * speed * meeting, np.inf, 0.0
    else:
        length = float(rng.uniform(3.5, 5.0))
        start = crossing - direction * length * rng.uniform(0.3, 0.7)
        phase = float(rng.uniform(0.0, 2.0 * length))
    return Walker(
        name=name,
        shape=Cylinder(radius, 0.85),
        start=start,
        direction=direction,
        speed=speed,
        length=length,
        phase=phase,
    )


def _walks_free(walker: Walker, where: Array, fixtures: list[Geom]) -> bool:
    reach = np.array(
        [
            np.hypot(*(where - fixture.pose.translation)[:, :2].T).min()
            - np.hypot(*half_extents(fixture.shape)[:2])
            for fixture in fixtures
        ]
    )
    return bool((reach > walker.shape.radius).all())
