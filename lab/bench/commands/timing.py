"""`bench timing`: the times of a control step, of a task's steps, the tree, perception, a start."""

from __future__ import annotations

from dataclasses import asdict
from enum import StrEnum
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.commands import find_tree
from lab.bench.commands.options import (
    BOTH,
    Json,
    Robot,
    check_writable,
    chosen_robots,
    show,
    write_json,
)

if TYPE_CHECKING:
    from lab.bench.timing import TimingReport


class Part(StrEnum):
    """A part of the software to time."""

    STEP = "step"
    """A control step on the way to seeded goals."""
    TASK = "task"
    """Every control step of a whole task."""
    TREE = "tree"
    """Reading a task file, and a tick."""
    PERCEPTION = "perception"
    """From a frame to grasps."""
    START = "start"
    """From `run` to the first words and the first motion; a `check`."""


class Reference(StrEnum):
    """A published implementation to compare with."""

    RTB = "rtb"


def timing(
    parts: Annotated[
        list[Part] | None, typer.Argument(help="What to time; default: all but `task`.")
    ] = None,
    robot: Robot = BOTH,
    versus: Annotated[
        Reference | None, typer.Option("--vs", help="step: also time the published example.")
    ] = None,
    task: Annotated[
        str, typer.Option(help="task, start: a task file or a shipped task.")
    ] = "pick_place",
    seed: Annotated[int, typer.Option(help="Seed of the goals, or of the task.", min=0)] = 0,
    count: Annotated[
        int | None, typer.Option(help="Steps, frames or starts; default: 10000, 60, 5.", min=1)
    ] = None,
    json: Json = None,
) -> None:
    """Time the parts of the software; other processes hardly disturb the CPU times."""
    from lab.bench.timing import timing_table

    check_writable(json)
    wanted = parts or [part for part in Part if part is not Part.TASK]
    report: dict[str, Any] = {}
    if Part.PERCEPTION in wanted:
        report["perception"] = _perception(count or 60)
    reports: list[TimingReport] = []
    for part in wanted:
        reports += _measured(part, robot, versus is Reference.RTB, task, seed, count)
    timings = [one for each in reports for one in each.timings]
    if timings:
        show(timing_table(timings), *(note for each in reports for note in each.notes))
    for each in reports:
        report |= each.figures
    write_json(json, {"results": [asdict(one) for one in timings], **report})


def _measured(
    part: Part, robot: str, against_rtb: bool, task: str, seed: int, count: int | None
) -> list[TimingReport]:
    from lab.bench.start_time import time_start
    from lab.bench.step_time import time_steps, time_task
    from lab.bench.timing import time_tree

    match part:
        case Part.STEP:
            steps = count or 10_000
            return [
                time_steps(name, steps=steps, against_rtb=against_rtb, seed=seed)
                for name in chosen_robots(robot)
            ]
        case Part.TASK:
            with TemporaryDirectory() as folder:
                return [
                    time_task(find_tree(task), name, seed, Path(folder))
                    for name in chosen_robots(robot)
                ]
        case Part.TREE:
            return [time_tree()]
        case Part.START:
            return [time_start(find_tree(task), count or 5)]
        case _:
            return []


def _perception(frames: int) -> dict[str, Any]:
    """Print the times of a perception step, and return them for the JSON file."""
    from json import loads

    from lab import grasps

    result = grasps.measure_perception(frames)
    show(grasps.perception_table(result), *grasps.perception_notes(result))
    figures: dict[str, Any] = loads(grasps.perception_json(result, {}))
    return figures
