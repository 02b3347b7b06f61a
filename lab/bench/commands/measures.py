"""`bench timing`: times of the parts; `bench experiments`: the figures of the documents again."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated

import typer

from app.commands import find_tree, refuse
from app.terminal import Terminal
from lab.bench.commands.options import (
    BOTH,
    Json,
    Robot,
    check_writable,
    chosen,
    chosen_robots,
    show,
    write_json,
    write_results,
)

if TYPE_CHECKING:
    from lab.bench.timing import TimingReport


PARTS = ("step", "task", "perception")
"""To time: control steps to seeded goals, every tick and step of a task, from a frame to grasps."""


def timing(
    parts: Annotated[
        list[str] | None, typer.Argument(help="step, task or perception; default: all but `task`.")
    ] = None,
    robot: Robot = BOTH,
    task: Annotated[str, typer.Option(help="task: a task file or a shipped task.")] = "pick_place",
    seed: Annotated[int, typer.Option(help="Seed of the goals, or of the task.", min=0)] = 0,
    count: Annotated[
        int | None, typer.Option(help="Steps or frames; default: 10000, 60.", min=1)
    ] = None,
    json: Json = None,
) -> None:
    """Time the parts of the software; other processes hardly disturb the CPU times."""
    from lab.bench.timing import timing_table

    check_writable(json)
    wanted = chosen("timing", parts or ["step", "perception"], PARTS)
    robots, tree = chosen_robots(robot), find_tree(task)
    reports = [one for part in wanted for one in _measured(part, robots, tree, seed, count)]
    timings = [one for report in reports for one in report.timings]
    show(timing_table(timings), *(note for report in reports for note in report.notes))
    write_results(json, timings)


def _measured(
    part: str, robots: list[str], tree: Path, seed: int, count: int | None
) -> list[TimingReport]:
    match part:
        case "step":
            from lab.bench.step_time import time_steps

            return [time_steps(name, steps=count or 10_000, seed=seed) for name in robots]
        case "task":
            from lab.bench.step_time import time_task

            with TemporaryDirectory() as folder:
                return [time_task(tree, name, seed, Path(folder)) for name in robots]
        case _:
            from lab.bench.perception_time import time_perception

            return [time_perception(count or 60)]


def experiments(
    file: Annotated[Path, typer.Argument(help="The list of experiments.")] = Path(
        "docs/experiments.yaml"
    ),
    quick: Annotated[
        bool, typer.Option("--quick", help="Small sizes: do all commands work? Judges nothing.")
    ] = False,
    only: Annotated[
        str | None, typer.Option(help="Only the tables whose name contains this.")
    ] = None,
    folder: Annotated[
        Path, typer.Option(help="Where the JSON and the output of each experiment go.")
    ] = Path("runs/experiments"),
    json: Json = None,
) -> None:
    """Run the experiments of the docs once more; compare each figure with its documented value.

    Ends with exit code 1 if a figure has changed.
    """
    from config import read_config
    from lab.bench.regenerate import Experiments, regenerate, regenerated_table

    check_writable(json)
    listed = read_config(file, Experiments).experiments
    wanted = [one for one in listed if (only or "").lower() in one.table.lower()]
    if not wanted:
        refuse(f"--only {only}: no table of {file} has this in its name")
    folder.mkdir(parents=True, exist_ok=True)
    done, seconds = [], 0.0
    for number, one in enumerate(wanted, 1):
        figures, duration = regenerate(one, folder, quick)
        done += figures
        seconds += duration
        Terminal(stderr=True).say(f"{number} of {len(wanted)}: {one.table}, {duration:.0f} s")
    changed = 0 if quick else sum(one.changed for one in done)
    summary = f"{len(done)} figures, {changed} changed, {seconds / 60.0:.1f} min"
    show(regenerated_table(done, quick), summary)
    rows = [asdict(one) | {"changed": one.changed and not quick} for one in done]
    about = {"quick": quick, "seconds": seconds, "changed": changed}
    write_json(json, {**about, "results": rows})
    if changed:
        raise typer.Exit(1)
