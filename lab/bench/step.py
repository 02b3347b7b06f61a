"""How long one step takes, on the way to real goals.

All controllers compute the same step from the same state, one after the other in an order that is
drawn again for every step, so that none has warmer caches or a quieter computer than the others.
The command of the first one moves the robot.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter_ns, thread_time_ns
from typing import Any

import numpy as np
from pinocchio import SE3
from rich.table import Table

from controller import (
    OPEN_FLOOR,
    STEP_PARTS,
    Array,
    Command,
    KinematicState,
    MotionGoal,
    PoseGoal,
    StepReport,
    Surroundings,
)
from lab.bench.configuration import Configuration
from lab.bench.motion import Controller, run_motion
from lab.bench.published import PublishedStep
from lab.shared import PartTimer

_LIMIT = 20.0
_STEPS_A_GOAL = 400
_TOLERANCES = (0.01, float(np.deg2rad(1.0)))

Step = Callable[[KinematicState, PoseGoal, Command], Any]
"""One step of a controller; what it returns is not compared."""


@dataclass(frozen=True, kw_only=True)
class Timing:
    """How long the steps of one controller took [µs]."""

    name: str
    steps: int
    median: float
    p95: float
    p99: float
    worst: float
    cpu_median: float
    """Of the thread's processor time, which other processes do not lengthen."""
    cpu_p95: float
    cpu_p99: float
    cpu_worst: float

    @classmethod
    def of(cls, name: str, wall_ns: Array, cpu_ns: Array) -> Timing:
        """From the times of all steps."""
        marks = (50.0, 95.0, 99.0, 100.0)
        wall, cpu = (np.percentile(times, marks) / 1e3 for times in (wall_ns, cpu_ns))
        return cls(
            name=name,
            steps=len(wall_ns),
            median=float(wall[0]),
            p95=float(wall[1]),
            p99=float(wall[2]),
            worst=float(wall[3]),
            cpu_median=float(cpu[0]),
            cpu_p95=float(cpu[1]),
            cpu_p99=float(cpu[2]),
            cpu_worst=float(cpu[3]),
        )


@dataclass(kw_only=True, eq=False)
class InterleavedTimer:
    """Steps like the first controller, and times all of them."""

    controllers: dict[str, Step]
    rng: np.random.Generator
    wall: dict[str, list[int]] = field(default_factory=dict)
    cpu: dict[str, list[int]] = field(default_factory=dict)
    results: list[dict[str, Any]] = field(default_factory=list)

    def step(
        self,
        state: KinematicState,
        goal: MotionGoal | None,
        last: Command,
        surroundings: Surroundings = OPEN_FLOOR,
    ) -> tuple[Command, StepReport]:
        """The step of every controller, on open floor; returns that of the first."""
        assert isinstance(goal, PoseGoal)
        names = list(self.controllers)
        results: dict[str, Any] = {}
        for index in self.rng.permutation(len(names)):
            name = names[index]
            step = self.controllers[name]
            wall, cpu = perf_counter_ns(), thread_time_ns()
            results[name] = step(state, goal, last)
            cpu, wall = thread_time_ns() - cpu, perf_counter_ns() - wall
            self.wall.setdefault(name, []).append(wall)
            self.cpu.setdefault(name, []).append(cpu)
        self.results.append(results)
        first: tuple[Command, StepReport] = results[names[0]]
        return first


@dataclass(frozen=True, kw_only=True)
class StepResult:
    """One robot's times."""

    robot: str
    timings: list[Timing]
    ratios: dict[str, float]
    """Of median processor times, by the names of the two."""
    agreement: float | None
    """Largest difference of the paper preset's velocities from the example's [rad/s and m/s]."""
    parts: dict[str, float]
    """Median processor times of the parts of a step of the preset `frankie` [µs]."""
    near: tuple[Timing, ...] = ()
    """Steps of the preset `frankie` with much near, and the same with nothing."""

    def with_near(self, near: Sequence[Timing]) -> StepResult:
        """This and steps with much near."""
        ratios = self.ratios
        if near:
            among, free = near
            ratios = ratios | {f"{among.name} / {free.name}": among.cpu_median / free.cpu_median}
        return replace(self, near=tuple(near), ratios=ratios)


EXAMPLE, CACHED = "rtb example", "rtb example, limits cached"


def time_steps(
    robot: str, goals: Sequence[SE3], *, steps: int, against_rtb: bool, seed: int
) -> StepResult:
    """Time the presets, and the published example if wanted, on the way to goals.

    Args:
        robot: frankie or omni.
        goals: where to go, in turn, until there are enough steps.
        steps: how many at least.
        against_rtb: whether the published example is timed too.
        seed: of the order of the controllers.

    Raises:
        ToolboxError: the example is asked for and not installed.
    """
    ours = Configuration(robot=robot)
    paper = Configuration(robot=robot, preset="paper")
    model, paper_model = ours.model(), paper.model()
    references: dict[str, Step] = {}
    if against_rtb:
        plain, cached = PublishedStep(robot), PublishedStep(robot)
        cached.cache_limits()
        references[EXAMPLE] = lambda state, goal, last: plain(state.wTb, state.q, goal.wTe)
        references[CACHED] = lambda state, goal, last: cached(state.wTb, state.q, goal.wTe)
    timer = InterleavedTimer(controllers={}, rng=np.random.default_rng(seed))
    gc.collect()
    gc.disable()
    try:
        for number in range(len(goals) * steps):
            frankie: Controller = ours.controller(model)
            timer.controllers = {
                "frankie": frankie.step,
                "paper": paper.controller(paper_model).step,
                **references,
            }
            _move_to(timer, ours, goals[number % len(goals)])
            gc.collect()
            if len(timer.results) >= steps:
                break
    finally:
        gc.enable()
    timings = [
        Timing.of(name, np.array(timer.wall[name]), np.array(timer.cpu[name]))
        for name in timer.controllers
    ]
    medians = {timing.name: timing.cpu_median for timing in timings}
    return StepResult(
        robot=robot,
        timings=timings,
        ratios={"frankie / paper": medians["frankie"] / medians["paper"]}
        | {
            f"{reference} / {own}": medians[reference] / medians[own]
            for reference in references
            for own in ("frankie", "paper")
        },
        agreement=_agreement(timer, paper_model.velocities) if references else None,
        parts=_parts(ours, goals[: max(1, len(timer.results) // _STEPS_A_GOAL // 4)]),
    )


def _move_to(controller: Controller, configuration: Configuration, wTe: SE3) -> None:
    model = configuration.model()
    goal = PoseGoal(
        wTe=wTe,
        speed=float(model.limits.base_twist[0]),
        position_tolerance=_TOLERANCES[0],
        orientation_tolerance=_TOLERANCES[1],
    )
    run_motion(controller, model, lambda time: goal, period=configuration.period, limit=_LIMIT)


def _parts(configuration: Configuration, goals: Sequence[SE3]) -> dict[str, float]:
    model = configuration.model()
    timer, controller = PartTimer(STEP_PARTS), configuration.controller(model)
    with timer.watching():
        for wTe in goals:
            _move_to(_Timed(controller, timer), configuration, wTe)
    return timer.medians()


@dataclass(frozen=True, eq=False)
class _Timed:
    """A controller whose steps are timed."""

    controller: Controller
    timer: PartTimer

    def step(
        self,
        state: KinematicState,
        goal: MotionGoal | None,
        last: Command,
        surroundings: Surroundings = OPEN_FLOOR,
    ) -> tuple[Command, StepReport]:
        """The command for the next period."""
        return self.timer.step(lambda: self.controller.step(state, goal, last, surroundings))


def _agreement(timer: InterleavedTimer, velocities: Callable[[Command], Array]) -> float:
    differences = [
        np.abs(velocities(results["paper"][0]) - results[EXAMPLE]).max()
        for results in timer.results
    ]
    return float(np.max(differences))


def step_table(results: Sequence[StepResult]) -> Table:
    """As a table."""
    table = Table(title="One step, in µs", title_justify="left")
    for name in ("robot", "step"):
        table.add_column(name)
    for name in ("median", "p95", "p99", "worst", "CPU median", "CPU p95", "CPU p99"):
        table.add_column(name, justify="right")
    for result in results:
        for timing in (*result.timings, *result.near):
            numbers = (
                timing.median,
                timing.p95,
                timing.p99,
                timing.worst,
                timing.cpu_median,
                timing.cpu_p95,
                timing.cpu_p99,
            )
            table.add_row(result.robot, timing.name, *(f"{number:.0f}" for number in numbers))
    return table


def step_notes(result: StepResult) -> list[str]:
    """Lines below the table: parts, ratios, agreement."""
    lines = []
    if result.parts:
        parts = ", ".join(f"{name} {time:.0f}" for name, time in result.parts.items())
        lines.append(f"{result.robot}: parts of a step of frankie (median µs): {parts}")
    lines += [
        f"{result.robot}, processor time: {name} = {ratio:.2f}"
        for name, ratio in result.ratios.items()
    ]
    if result.agreement is not None:
        lines.append(
            f"{result.robot}: paper and rtb example differ by at most {result.agreement:.1e}"
        )
    return lines
