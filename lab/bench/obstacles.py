"""Many seeded worlds with obstacles: is the goal reached, how fast, and what is touched."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from controller import OPEN_FLOOR, HolisticController, PoseGoal, StepReport, Surroundings
from lab.bench.configuration import Configuration
from lab.bench.evaluation import Evaluator, Trial
from lab.bench.motion import Motion, SurroundingsAt, run_motion
from lab.bench.obstacle_judge import Judge, Verdict
from lab.bench.obstacle_worlds import FAMILIES, World, WorldMaker
from lab.bench.reach import Conditions
from lab.shared import run_all

OURS, BLIND = "frankie", "blind"
"""The controller, and the same one when it is told nothing of what is around."""

_PRESETS: dict[str, dict[str, Any]] = {
    OURS: {},
    "without guidance": {"changes": (("guidance", None),)},
    "paper": {"preset": "paper"},
    BLIND: {},
}
CONTROLLERS = tuple(_PRESETS)
"""What can be compared: ours, its rows alone, the published one, ours without eyes."""


@dataclass(frozen=True, kw_only=True)
class Setup:
    """Who is measured, and how; can be sent to another process."""

    robot: str
    controllers: tuple[str, ...] = CONTROLLERS
    base_speed: float | None = None
    """Largest speed of the base [m/s]; None is that of the description."""
    period: float = 0.01
    """Control period [s]."""
    lag: bool = True
    """Whether base and arm follow their commands with lag."""
    seed: int = 0
    """Of the worlds."""
    conditions: Conditions = field(default_factory=lambda: Conditions(limit=40.0))

    def configuration(self, controller: str) -> Configuration:
        """The robot with one of the controllers; all have the same largest base speed."""
        speed = self.base_speed
        if speed is None:
            speed = float(Configuration(robot=self.robot).model().limits.base_twist[0])
        changes = _PRESETS[controller]
        return Configuration(robot=self.robot, base_speed=speed, period=self.period, **changes)


@dataclass(frozen=True, kw_only=True)
class WorldTrial:
    """One controller in one world."""

    controller: str
    family: str
    number: int
    trial: Trial
    verdict: Verdict
    free_time: float | None
    """Time to the same goal without obstacles [s]; None if it is not reached then either."""
    told: str
    """Why the controller says that the goal is unreachable; it never is."""

    @property
    def name(self) -> str:
        """Of the world."""
        return f"{self.family}:{self.number}"

    @property
    def reason(self) -> str | None:
        """Why this is a failure; None if the goal was reached, and nothing touched on the way."""
        if self.trial.failure is not None:
            return str(self.trial.failure)
        if self.verdict.avoidable_samples or self.trial.contacts.samples:
            return "contact"
        return "over limit" if self.trial.violations.samples else None


@lru_cache(maxsize=2)
def _worlds(robot: str) -> WorldMaker:
    return WorldMaker(Configuration(robot=robot).model())


@lru_cache(maxsize=8)
def _evaluator(configuration: Configuration) -> Evaluator:
    return Evaluator(configuration.model())


def world_names(count: int, families: Sequence[str] = FAMILIES) -> list[tuple[str, int]]:
    """Families and numbers of `count` worlds, the families in turn."""
    return [(families[i % len(families)], i // len(families)) for i in range(count)]


def make_world(setup: Setup, family: str, number: int) -> World:
    """One of the worlds."""
    return _worlds(setup.robot)(family, number, setup.seed)


def run_world(
    setup: Setup,
    controller: str,
    world: World,
    watch: Callable[[float, StepReport], None] = lambda time, report: None,
) -> Motion:
    """The motion of one controller in a world."""
    configuration = setup.configuration(controller)
    model = _evaluator(configuration).model
    conditions = setup.conditions
    goal = PoseGoal(
        wTe=world.goal,
        speed=float(model.limits.base_twist[0]),
        position_tolerance=conditions.position_tolerance,
        orientation_tolerance=conditions.orientation_tolerance,
    )
    around: SurroundingsAt = _nothing if controller == BLIND else world.surroundings
    robot = configuration.controller(model)
    if isinstance(robot, HolisticController):
        robot.prepare(around(0.0))
    return run_motion(
        robot,
        model,
        lambda time: goal,
        period=setup.period,
        limit=conditions.limit,
        patience=conditions.patience,
        surroundings_at=around,
        lag=setup.lag,
        watch=watch,
    )


def _nothing(time: float) -> Surroundings:
    return OPEN_FLOOR


def judge_world(
    setup: Setup, controller: str, world: World, motion: Motion, free_time: float | None
) -> WorldTrial:
    """What a motion is worth."""
    evaluator = _evaluator(setup.configuration(controller))
    judge = Judge(evaluator.model.description)
    return WorldTrial(
        controller=controller,
        family=world.family,
        number=world.number,
        trial=evaluator(motion),
        verdict=judge(motion.base, motion.q, motion.period, world.fixtures, world.walkers),
        free_time=free_time,
        told=motion.unreachable,
    )


def _trials(task: tuple[Setup, str, int]) -> list[WorldTrial]:
    setup, family, number = task
    world = make_world(setup, family, number)
    free = run_world(setup, BLIND, world)
    time = free.duration if free.arrived else None
    return [
        judge_world(
            setup,
            controller,
            world,
            free if controller == BLIND else run_world(setup, controller, world),
            time,
        )
        for controller in setup.controllers
    ]


def run_worlds(
    setup: Setup,
    names: Sequence[tuple[str, int]],
    *,
    workers: int = 1,
    cluster: str | None = None,
) -> Iterator[tuple[int, list[WorldTrial]]]:
    """All controllers in every world; yields the index of the name and the trials."""
    tasks = [(setup, family, number) for family, number in names]
    return run_all(_trials, tasks, workers=workers, cluster=cluster)


def median_interval(values: Sequence[float]) -> tuple[float, float, float] | None:
    """Median and its 95 % interval by a seeded bootstrap; None without values."""
    if not values:
        return None
    sample = np.array(values)
    drawn = np.random.default_rng(0).integers(len(sample), size=(1000, len(sample)))
    low, high = np.percentile(np.median(sample[drawn], axis=1), (2.5, 97.5))
    return float(np.median(sample)), float(low), float(high)
