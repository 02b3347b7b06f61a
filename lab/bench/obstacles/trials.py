"""Trials of several controllers in seeded worlds with obstacles."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from controller import OPEN_FLOOR, PoseGoal
from lab.bench.configuration import Configuration
from lab.bench.motion_evaluation import Trial
from lab.bench.obstacles.contact_judge import Judge, Verdict
from lab.bench.obstacles.obstacle_worlds import FAMILIES, World, WorldMaker
from lab.bench.reaching import PATIENCE, Conditions, evaluator_of
from lab.bench.simulated_motion import Motion, run_motion
from lab.shared import run_in_order

BLIND = "blind"  # our controller without any obstacle

_PRESETS: dict[str, dict[str, Any]] = {"frankie": {}, "paper": {"preset": "paper"}, BLIND: {}}
_CONDITIONS = Conditions()
CONTROLLERS = tuple(_PRESETS)  # ours, the published one, and ours without obstacles


@dataclass(frozen=True, kw_only=True)
class Setup:
    """A robot, its controllers and the worlds; can be sent to another process."""

    robot: str
    controllers: tuple[str, ...] = CONTROLLERS
    seed: int = 0  # of the worlds
    limit: float = 40.0  # longest time for each goal [s]

    def configuration(self, controller: str) -> Configuration:
        """The robot with one of the controllers; all have the same largest base speed."""
        speed = float(Configuration(robot=self.robot).model().limits.base_twist[0])
        return Configuration(robot=self.robot, base_speed=speed, **_PRESETS[controller])


@dataclass(frozen=True, kw_only=True)
class WorldTrial:
    """One controller in one world."""

    controller: str
    family: str
    number: int
    trial: Trial
    verdict: Verdict
    free_time: float | None
    """Time to the same goal without obstacles [s]; None if it was not reached then either."""
    unreachable: str  # why the controller reported the goal as unreachable, which it never is

    @property
    def name(self) -> str:
        """Of the world."""
        return f"{self.family}:{self.number}"

    @property
    def reason(self) -> str | None:
        """Why this is a failure; None if the goal was reached without an avoidable contact."""
        if self.trial.failure is not None:
            return str(self.trial.failure)
        if self.verdict.avoidable_samples or self.trial.contact_samples:
            return "contact"
        return "over limit" if self.trial.limit_violations else None


@lru_cache(maxsize=2)
def _worlds(robot: str) -> WorldMaker:
    return WorldMaker(Configuration(robot=robot).model())


def world_names(count: int) -> list[tuple[str, int]]:
    """Families and numbers of `count` worlds, the families in turn."""
    return [(FAMILIES[i % len(FAMILIES)], i // len(FAMILIES)) for i in range(count)]


def run_world(setup: Setup, controller: str, world: World) -> Motion:
    """The motion of one controller in a world."""
    configuration = setup.configuration(controller)
    model = evaluator_of(configuration).model
    goal = PoseGoal(
        target=world.goal,
        speed=float(model.limits.base_twist[0]),
        position_tolerance=_CONDITIONS.position_tolerance,
        orientation_tolerance=_CONDITIONS.orientation_tolerance,
    )
    around = (lambda time: OPEN_FLOOR) if controller == BLIND else world.surroundings
    prepared = configuration.controller(model)
    prepared.prepare(around(0.0))
    return run_motion(
        prepared.step,
        model,
        lambda time: goal,
        period=configuration.period,
        limit=setup.limit,
        patience=PATIENCE,
        surroundings_at=around,
        lag=True,
    )


def _trials(task: tuple[Setup, str, int]) -> list[WorldTrial]:
    setup, family, number = task
    world = _worlds(setup.robot)(family, number, setup.seed)
    free = run_world(setup, BLIND, world)
    found = []
    for controller in setup.controllers:
        motion = free if controller == BLIND else run_world(setup, controller, world)
        evaluator = evaluator_of(setup.configuration(controller))
        judge = Judge(evaluator.model.description)
        found.append(
            WorldTrial(
                controller=controller,
                family=family,
                number=number,
                trial=evaluator(motion),
                verdict=judge(motion.base, motion.q, motion.period, world.fixtures, world.walkers),
                free_time=free.duration if free.arrived else None,
                unreachable=motion.unreachable,
            )
        )
    return found


def run_worlds(
    setup: Setup,
    names: Sequence[tuple[str, int]],
    done: Callable[[list[WorldTrial]], None],
    workers: int | str | None,
) -> list[list[WorldTrial]]:
    """The trials of all controllers in every world; `done` is called after each world."""
    tasks = [(setup, *name) for name in names]
    return run_in_order(_trials, tasks, done, workers=workers)
