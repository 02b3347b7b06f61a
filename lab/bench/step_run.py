"""How long every control step of a whole run takes, and what the slowest were busy with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.table import Table

from app.core import Instruments, RunOptions, Setup, run_task
from controller import STEP_PARTS, Command, KinematicState, MotionGoal, StepReport, Surroundings
from lab.bench.step import Timing
from lab.shared import PartTimer
from trees.language import TreeNode

_WORST = 5
"""Steps that are told of, the slowest."""


@dataclass(frozen=True, kw_only=True)
class SlowStep:
    """One of the slowest steps."""

    number: int
    time: float
    """Processor time [µs]."""
    parts: dict[str, float]
    """Of its parts [µs]."""


@dataclass(frozen=True, kw_only=True)
class RunSteps:
    """The control steps of one run; the search for stances and ways is a part of them."""

    timing: Timing
    """Of all steps; telling the parts from each other is in it."""
    placed: int
    slowest: list[SlowStep]


class _StepTimer(Instruments):
    """Times every step of the controller of a run."""

    def __init__(self) -> None:
        self.timer = PartTimer(STEP_PARTS)

    def begin(self, setup: Setup, nodes: Sequence[TreeNode]) -> None:
        """Get between the loop and the controller."""
        controller, timer = setup.controller, self.timer
        plain = controller.step

        def step(
            state: KinematicState, goal: MotionGoal | None, last: Command, around: Surroundings
        ) -> tuple[Command, StepReport]:
            return timer.step(lambda: plain(state, goal, last, around))

        # The loop calls what this controller has by that name.
        controller.step = step  # type: ignore[method-assign, assignment]


def time_run(options: RunOptions) -> RunSteps:
    """Run a task and time every control step.

    Args:
        options: of the run.

    Raises:
        UserError: bad input; nothing has moved.
    """
    instruments = _StepTimer()
    timer = instruments.timer
    with timer.watching():
        summary = run_task(options, instruments=instruments).summary
    wall, cpu = timer.wall_ns(), timer.cpu_ns()
    slowest = [
        SlowStep(
            number=int(number),
            time=float(cpu[number]) / 1e3,
            parts={name: ns / 1e3 for name, ns in timer.parts_ns(int(number)).items()},
        )
        for number in np.argsort(-cpu, kind="stable")[:_WORST]
    ]
    name = f"{summary.robot}: {summary.task}, {summary.scene}, seed {summary.seed}"
    timing = Timing.of(name, wall, cpu)
    return RunSteps(timing=timing, placed=summary.placed, slowest=slowest)


def run_steps_table(runs: Sequence[RunSteps]) -> Table:
    """One row for every run."""
    table = Table(title="Control steps of whole runs, processor time in µs", title_justify="left")
    for name in ("run", "steps", "median", "p95", "p99", "worst", "placed"):
        table.add_column(name, justify="left" if name == "run" else "right")
    for run in runs:
        t = run.timing
        times = (t.cpu_median, t.cpu_p95, t.cpu_p99, t.cpu_worst)
        table.add_row(t.name, str(t.steps), *(f"{x:.0f}" for x in times), str(run.placed))
    return table


def run_steps_notes(run: RunSteps) -> list[str]:
    """The slowest steps, and the parts of each that took longest."""
    lines = []
    for slow in run.slowest:
        parts = sorted(slow.parts.items(), key=lambda part: -part[1])[:3]
        text = ", ".join(f"{name} {time:.0f}" for name, time in parts)
        lines.append(f"{run.timing.name}: step {slow.number} took {slow.time:.0f} µs: {text}")
    return lines
