"""Time of a control step: ours beside its peers, on the way to seeded goals.

All controllers compute the same step from the same state; the command of ours moves the robot.
"""

import gc
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from rich.table import Table

from config.poses import MapPose
from controller import Command, PoseGoal, StepReport
from lab.bench.configuration import Configuration
from lab.bench.goals import generate_goals
from lab.bench.peers import LACKS
from lab.bench.simulated_motion import Step, run_motion
from lab.bench.timing import Interleaved
from lab.shared import fixed, machine, table

_GOALS = 100
_LIMIT = 20.0  # of one motion [s]


@dataclass(frozen=True, kw_only=True)
class StepTime:
    """Processor time of the steps of one controller [µs]."""

    robot: str
    controller: str
    steps: int
    median: float
    p99: float
    ratio: float  # of its median to ours
    infeasible: int  # steps without a solution of the QP
    lacks: str  # what it does not do


def time_steps(robot: str, peers: Sequence[str], *, steps: int, seed: int) -> list[StepTime]:
    """Time our controller and its peers on the way to goals.

    Raises:
        ConfigError: a peer is not installed.
    """
    ours = Configuration(robot=robot)
    model = ours.model()
    goals = generate_goals(model, _GOALS, seed)
    others = {name: Configuration(robot=robot, preset=name).step(ours.model()) for name in peers}
    timer, infeasible, number = Interleaved(seed), Counter[str](), 0
    gc.collect()
    gc.disable()
    try:
        while timer.steps < steps:
            every = {"frankie": ours.step(model), **others}
            counted = {name: _counted(name, one, infeasible) for name, one in every.items()}
            _move_to(_interleaved(counted, timer), ours, goals[number % _GOALS])
            gc.collect()
            number += 1
    finally:
        gc.enable()
    timings = timer.timings(("frankie", *peers))
    return [
        StepTime(
            robot=robot,
            controller=t.name,
            steps=t.steps,
            median=t.median,
            p99=t.p99,
            ratio=t.median / timings[0].median,
            infeasible=infeasible[t.name],
            lacks=LACKS.get(t.name, ""),
        )
        for t in timings
    ]


def step_table(rows: Sequence[StepTime]) -> Table:
    """One row for every controller."""
    return table(
        f"Processor time of a step in µs, on {machine()['machine']}",
        rows,
        {
            "robot": lambda row: row.robot,
            "controller": lambda row: row.controller,
            "without": lambda row: row.lacks or "-",
        },
        {
            "steps": lambda row: row.steps,
            "median": lambda row: fixed(row.median, 0),
            "p99": lambda row: fixed(row.p99, 0),
            "of ours": lambda row: fixed(row.ratio, 2),
            "unsolved": lambda row: row.infeasible,
        },
        title_justify="left",
    )


def _counted(name: str, step: Step, infeasible: Counter[str]) -> Step:
    """A step that counts those without a solution."""

    def counted(*arguments: Any) -> tuple[Command, StepReport]:
        command, report = step(*arguments)
        infeasible[name] += not report.solved
        return command, report

    return counted


def _interleaved(steps: dict[str, Step], timer: Interleaved) -> Step:
    return lambda *arguments: timer({name: partial(one, *arguments) for name, one in steps.items()})


def _move_to(step: Step, configuration: Configuration, mTe: MapPose) -> None:
    model = configuration.model()
    goal = PoseGoal(
        target=mTe,
        speed=float(model.limits.base_twist[0]),
        position_tolerance=0.01,
        orientation_tolerance=float(np.deg2rad(1.0)),
    )
    run_motion(step, model, lambda time: goal, period=configuration.period, limit=_LIMIT)
