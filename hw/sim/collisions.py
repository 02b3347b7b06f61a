"""Collisions of the robot with the world, with a conservative bound on the gap of each pair.

Two shapes a gap apart cannot meet before they have moved that far towards each other. So every pair
keeps its last measured gap, less the largest possible motion of both since then; Coal measures
again only where nothing is left of it.
"""

from typing import NamedTuple, TypeAlias

import coal
import numpy as np
from pinocchio import SE3

from controller import RobotModel
from hw.sim.contact import SIGNED, transform
from hw.sim.sim_object import SimObject
from hw.sim.sim_robot_shapes import (
    BASE,
    FINGERS,
    HAND,
    HELD,
    Member,
    finger_side,
    frames,
    held_members,
    members,
)
from hw.sim.sim_world import World
from hw.sim.walker import Walker
from robots import Array, Plane, bounding_radius, coal_geometry

Movable: TypeAlias = SimObject | Walker

_DUE = -1.0  # gap of a pair that was never measured [m]


class Contact(NamedTuple):
    """A part of the robot overlaps with an obstacle or object."""

    part: str
    thing: str
    depth: float  # [m]
    excess: float  # depth beyond the tolerance; negative for a mere touch [m]
    towards: Array  # (3,) unit normal from the robot to it
    owner: Movable | None  # The obstacle or object, if it can move
    text: str  # For people: who hit what


class _Thing:
    """An object or walker, and its columns in the table of pairs."""

    def __init__(self, one: Movable, first: int) -> None:
        self.one = one
        self.columns = slice(first, first + len(one.parts))
        self.seen: SE3 | None = None

    def travel(self) -> float:
        """Largest motion of any of its points since the last call [m]."""
        pose, seen = self.one.pose, self.seen
        self.seen = pose.copy()
        if seen is None:
            return 0.0
        moved = float(np.linalg.norm(pose.translation - seen.translation))
        if isinstance(self.one, SimObject) and not np.array_equal(pose.rotation, seen.rotation):
            moved += 2.0 * self.one.radius
        return moved


class Collisions:
    """Collision detection of one robot in one world."""

    def __init__(self, model: RobotModel, world: World) -> None:
        self._model = model
        self._world = world
        self._own = members(model.description)
        self._take(self._own)
        self._shapes = list(world.fixtures)
        self._things: list[_Thing] = []
        movable: tuple[Movable, ...] = (*world.walkers, *world.objects)
        for one in movable:
            self._things.append(_Thing(one, len(self._shapes)))
            self._shapes += one.parts
        self._names = [shape.name for shape in world.fixtures]
        self._owners: list[Movable | None] = [None] * len(world.fixtures)
        for thing in self._things:
            self._names += [thing.one.name] * len(thing.one.parts)
            self._owners += [thing.one] * len(thing.one.parts)
        self._geometries = [coal_geometry(shape.shape) for shape in self._shapes]
        self._placed = [transform(shape.pose) for shape in self._shapes]
        self._gaps = np.full((len(self._own), len(self._shapes)), _DUE)  # left of each at least [m]
        for row, member in enumerate(self._own):
            for column, shape in enumerate(self._shapes):
                if member.part == BASE and isinstance(shape.shape, Plane):
                    self._gaps[row, column] = np.inf  # it stands there
        self._held: SimObject | None = None
        self._eTo: SE3 | None = None
        self._before: Array | None = None  # the poses of the last `find`

    def find(self, wTb: SE3, q: Array, width: float) -> list[Contact]:
        """The contacts, the deepest one of each part with each thing.

        The robot is at q (j,) [rad], its pads `width` apart [m].
        """
        here = np.array([frame.homogeneous for frame in frames(self._model, wTb, q)])
        placed = here[self._frame] @ (self._at + width * self._opens)
        if self._before is not None:
            self._gaps -= self._travel(placed - self._before)
        if self._world.held is not self._held or self._world.eTs is not self._eTo:
            self._update_held(self._world.held)
            placed = here[self._frame] @ (self._at + width * self._opens)
        self._before = placed
        for thing in self._things:
            if thing.one is not self._held and thing.one.pose != thing.seen:
                self._gaps[:, thing.columns] -= thing.travel()
                for column in range(thing.columns.start, thing.columns.stop):
                    pose = thing.one.pose * self._shapes[column].pose
                    self._placed[column] = transform(pose)
        due = np.argwhere(self._gaps < 0.0).tolist()
        return self._measure(due, placed) if due else []

    def _take(self, rows: list[Member]) -> None:
        """Check these shapes of the robot."""
        self._rows = rows
        self._frame = np.array([row.frame for row in rows])
        self._radius = np.array([bounding_radius(row.geom.shape) for row in rows])
        self._opens = np.zeros((len(rows), 4, 4))  # change of its pose by the width
        for opens, row in zip(self._opens, rows, strict=True):
            opens[1, 3] = 0.5 * finger_side(row)
        opening = self._model.description.gripper.opening
        self._at = np.array([row.geom.pose.homogeneous for row in rows]) - opening * self._opens

    def _travel(self, change: Array) -> Array:
        """(M, 1) largest motion of a point of each shape [m], for changes (M, 4, 4) of its pose.

        That of its centre, and its radius times the turn, by which no unit vector moves farther
        than the root of half the squares of the change of the rotation matrix.
        """
        squares = np.square(change[:, :3])
        centre, turn = squares[:, :, 3].sum(axis=1), 0.5 * squares[:, :, :3].sum(axis=(1, 2))
        return np.asarray(np.sqrt(centre) + self._radius * np.sqrt(turn))[:, None]

    def _measure(self, due: list[list[int]], placed: Array) -> list[Contact]:
        found: dict[tuple[str, str], Contact] = {}
        poses = placed[:, :3]
        own = {row: coal.Transform3s(poses[row, :, :3], poses[row, :, 3]) for row, _ in due}
        result = coal.DistanceResult()
        for row, column in due:
            member = self._rows[row]
            result.clear()
            gap = coal.distance(
                coal_geometry(member.geom.shape),
                own[row],
                self._geometries[column],
                self._placed[column],
                SIGNED,
                result,
            )
            self._gaps[row, column] = gap
            key = member.part, self._names[column]
            if gap < 0.0 and (key not in found or -gap > found[key].depth):
                normal = np.array(result.normal)
                text = f"{_part_text(member.part, self._held)} hit {self._names[column]}"
                excess = -gap - member.tolerance
                found[key] = Contact(*key, -gap, excess, normal, self._owners[column], text)
        return list(found.values())

    def _update_held(self, held: SimObject | None) -> None:
        """Check the object in the hand with the robot, and a released one as an obstacle."""
        gaps = self._gaps[: len(self._own)]
        for thing in self._things:
            if thing.one is self._held:
                gaps[:, thing.columns] = _DUE
            if thing.one is held:
                gaps[:, thing.columns] = np.inf
        self._held, self._eTo = held, self._world.eTs
        extra = held_members(held, self._world.eTs) if held is not None else []
        against = np.full((len(extra), len(self._shapes)), _DUE)
        for thing in self._things:
            if isinstance(thing.one, SimObject):  # it may touch them, as when it is set on them
                against[:, thing.columns] = np.inf
        self._take([*self._own, *extra])
        self._gaps = np.concatenate([gaps, against])


def _part_text(part: str, held: SimObject | None) -> str:
    if part.startswith("link"):
        return part
    if part == HELD and held is not None:
        return f"{held.name} in the hand"
    return f"the {HAND if part == FINGERS else part}"
