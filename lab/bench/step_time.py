"""Time of a control step: of the presets on the way to seeded goals, and in a whole task.

All controllers compute the same step from the same state, in an order that is drawn again for every
step, so that none has warmer caches or a less busy computer. The command of the first one moves
the robot.
"""

from __future__ import annotations

import gc
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter_ns, thread_time_ns

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
from lab.bench.timing import Timing, TimingReport
from lab.shared import PartTimer
from trees.language import TreeNode

_GOALS = 100
_LIMIT = 20.0
"""Of one motion [s]."""
_STEPS_A_GOAL = 400
_WORST = 5
"""Number of the slowest steps of a run that are listed."""


class InterleavedTimer:
    """Times the steps of several controllers; the first one's command is used.

    Args:
        rng: of the order of the controllers.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self.steps: dict[str, Step] = {}
        self.wall: defaultdict[str, list[int]] = defaultdict(list)
        self.cpu: defaultdict[str, list[int]] = defaultdict(list)
        self._rng = rng

    def step(
        self,
        state: KinematicState,
        goal: MotionGoal | None,
        last: Command,
        surroundings: Surroundings,
    ) -> tuple[Command, StepReport]:
        """The step of every controller; returns that of the first."""
        names, results = list(self.steps), {}
        for index in self._rng.permutation(len(names)):
            name = names[index]
            step = self.steps[name]
            wall, cpu = perf_counter_ns(), thread_time_ns()
            results[name] = step(state, goal, last, surroundings)
            cpu, wall = thread_time_ns() - cpu, perf_counter_ns() - wall
            self.wall[name].append(wall)
            self.cpu[name].append(cpu)
        return results[names[0]]


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
    timer = InterleavedTimer(np.random.default_rng(seed))
    gc.collect()
    gc.disable()
    try:
        for number in range(len(goals) * steps):
            timer.steps = {"frankie": ours.step(model), "paper": paper.step(paper_model)}
            _move_to(timer.step, ours, goals[number % len(goals)])
            gc.collect()
            if len(timer.wall["paper"]) >= steps:
                break
    finally:
        gc.enable()
    timings = [
        Timing.of(f"{robot}: {name}", np.array(timer.wall[name]), np.array(timer.cpu[name]))
        for name in timer.steps
    ]
    parts = _parts(ours, goals[: max(1, len(timer.wall["paper"]) // _STEPS_A_GOAL // 4)])
    listed = ", ".join(f"{name} {time:.0f}" for name, time in parts.items())
    ratio = timings[0].cpu_median / timings[1].cpu_median
    notes = [
        f"{robot}: parts of a step of frankie (median µs): {listed}",
        f"{robot}, CPU time: frankie / paper = {ratio:.2f}",
    ]
    return TimingReport(timings=timings, notes=notes)


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
