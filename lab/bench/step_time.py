"""Time of a control step: of the presets on the way to seeded goals, and in a whole task.

All controllers compute the same step from the same state; the command of the first one moves the
robot.
"""

import gc
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
from pinocchio import SE3

from app.core import Instruments, RunOptions, Setup, Tick, run_task
from controller import Command, KinematicState, MotionGoal, PoseGoal, StepReport, Surroundings
from lab.bench.configuration import Configuration
from lab.bench.goals import generate_goals
from lab.bench.motion import Step, run_motion
from lab.bench.timing import Interleaved, Timing, TimingReport
from trees.language import TreeNode

_GOALS = 100
_LIMIT = 20.0  # of one motion [s]


def time_steps(robot: str, *, steps: int, seed: int) -> TimingReport:
    """Time our controller and the paper's on the way to goals."""
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
    ratio = timings[0].cpu_median / timings[1].cpu_median
    return TimingReport(
        timings=timings, notes=[f"{robot}, CPU time: frankie / paper = {ratio:.2f}"]
    )


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


class _StepTimer(Instruments):
    """Times every tick of a run and the controller's step in it."""

    def __init__(self) -> None:
        self.timer = Interleaved(0)
        self.ticks: list[float] = []

    def after(self, tick: Tick) -> None:
        """Note the duration of the tick."""
        self.ticks.append(tick.seconds)

    def begin(self, setup: Setup, nodes: Sequence[TreeNode]) -> None:
        """Wrap the controller's step, which the loop looks up on this object."""
        step = _interleaved({"step": setup.controller.step}, self.timer)
        setup.controller.step = step  # type: ignore[method-assign, assignment]


def time_task(tree: Path, robot: str, seed: int, record: Path) -> TimingReport:
    """Run a task and time every tick, and the control step in it with stances and routes.

    Raises UserError: bad input; nothing has moved.
    """
    options = RunOptions(
        tree=tree, robot=robot, seed=seed, localisation="exact", record=record, recording=False
    )
    instruments = _StepTimer()
    summary = run_task(options, instruments=instruments).summary
    name = f"{summary.robot}: {summary.task}, {summary.scene}, seed {summary.seed}, "
    ticks = Timing.of(f"{name}tick", 1e9 * np.array(instruments.ticks))
    return TimingReport(timings=[*instruments.timer.timings(["step"], name), ticks])
