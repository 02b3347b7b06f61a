"""Time of a control step: of the presets on the way to seeded goals, and in a whole task.

All controllers compute the same step from the same state; the command of the first one moves the
robot.
"""

from __future__ import annotations

import gc
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
from pinocchio import SE3

from app.core import Instruments, RunOptions, Setup, Tick, run_task
from controller import (
    STEP_PARTS,
    Command,
    KinematicState,
    MotionGoal,
    PoseGoal,
    StepReport,
    Surroundings,
)
from lab.bench.configuration import Configuration
from lab.bench.goals import generate_goals
from lab.bench.motion import Step, run_motion
from lab.bench.timing import Interleaved, Timing, TimingReport
from lab.shared import PartTimer
from trees.language import TreeNode

_GOALS = 100
_LIMIT = 20.0
"""Of one motion [s]."""
_STEPS_A_GOAL = 400
_WORST = 5
"""Number of the slowest steps of a run that are listed."""


def time_steps(robot: str, *, steps: int, seed: int) -> TimingReport:
    """Time our controller and the paper's on the way to goals.

    Args:
        robot: frankie or omni.
        steps: least number of steps.
        seed: of the goals and of the order of the controllers.
    """
    ours = Configuration(robot=robot)
    paper = Configuration(robot=robot, preset="paper")
    model, paper_model = ours.model(), paper.model()
    goals = generate_goals(model, _GOALS, seed)
    timer, number = Interleaved(seed), 0
    gc.collect()
    gc.disable()
    try:
        while timer.steps < steps:
            both = {"frankie": ours.step(model), "paper": paper.step(paper_model)}
            _move_to(_interleaved(both, timer), ours, goals[number % _GOALS])
            gc.collect()
            number += 1
    finally:
        gc.enable()
    timings = timer.timings(("frankie", "paper"), f"{robot}: ")
    parts = _parts(ours, goals[: max(1, timer.steps // _STEPS_A_GOAL // 4)])
    listed = ", ".join(f"{name} {time:.0f}" for name, time in parts.items())
    ratio = timings[0].cpu_median / timings[1].cpu_median
    notes = [
        f"{robot}: parts of a step of frankie (median µs): {listed}",
        f"{robot}, CPU time: frankie / paper = {ratio:.2f}",
    ]
    return TimingReport(timings=timings, notes=notes)


def _interleaved(steps: dict[str, Step], timer: Interleaved) -> Step:
    def step(
        state: KinematicState, goal: MotionGoal | None, last: Command, surroundings: Surroundings
    ) -> tuple[Command, StepReport]:
        arguments = (state, goal, last, surroundings)
        return timer({name: partial(one, *arguments) for name, one in steps.items()})

    return step


def _move_to(step: Step, configuration: Configuration, wTe: SE3) -> None:
    model = configuration.model()
    goal = PoseGoal(
        wTe=wTe,
        speed=float(model.limits.base_twist[0]),
        position_tolerance=0.01,
        orientation_tolerance=float(np.deg2rad(1.0)),
    )
    run_motion(step, model, lambda time: goal, period=configuration.period, limit=_LIMIT)


def _parts(configuration: Configuration, goals: Sequence[SE3]) -> dict[str, float]:
    """Median CPU time of the parts of a step [µs]."""
    timer = PartTimer(STEP_PARTS)
    step = _timed(configuration.step(configuration.model()), timer)
    with timer.measuring():
        for wTe in goals:
            _move_to(step, configuration, wTe)
    return timer.medians()


def _timed(plain: Step, timer: PartTimer) -> Step:
    def step(
        state: KinematicState, goal: MotionGoal | None, last: Command, surroundings: Surroundings
    ) -> tuple[Command, StepReport]:
        return timer.step(lambda: plain(state, goal, last, surroundings))

    return step


class _StepTimer(Instruments):
    """Times every tick of a run and the controller's step in it."""

    def __init__(self) -> None:
        self.timer = PartTimer(STEP_PARTS)
        self.ticks: list[float] = []

    def after(self, tick: Tick) -> None:
        """Note the duration of the tick."""
        self.ticks.append(tick.seconds)

    def begin(self, setup: Setup, nodes: Sequence[TreeNode]) -> None:
        """Wrap the controller's step."""
        # The loop looks the method up on this object.
        step = _timed(setup.controller.step, self.timer)
        setup.controller.step = step  # type: ignore[method-assign, assignment]


def time_task(tree: Path, robot: str, seed: int, record: Path) -> TimingReport:
    """Run a task and time every tick, and the control step in it with stances and routes.

    Raises:
        UserError: bad input; nothing has moved.
    """
    options = RunOptions(tree=tree, robot=robot, seed=seed, record=record, recording=False)
    instruments = _StepTimer()
    timer = instruments.timer
    with timer.measuring():
        summary = run_task(options, instruments=instruments).summary
    wall, cpu = timer.times_ns()
    name = f"{summary.robot}: {summary.task}, {summary.scene}, seed {summary.seed}"
    notes = []
    for number in np.argsort(-cpu, kind="stable")[:_WORST].tolist():
        parts = sorted(timer.parts_ns(number).items(), key=lambda part: -part[1])[:3]
        listed = ", ".join(f"{part} {ns / 1e3:.0f}" for part, ns in parts)
        notes.append(f"{name}: step {number} took {cpu[number] / 1e3:.0f} µs: {listed}")
    ticks = Timing.of(f"{name}, whole ticks", 1e9 * np.array(instruments.ticks))
    return TimingReport(timings=[Timing.of(name, wall, cpu), ticks], notes=notes)
