"""`bench step`, `tree`, `perception`, `watch` and `start`: the time that parts of a run take."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from app.commands import find_tree
from lab.commands.options import (
    BOTH,
    Json,
    Robot,
    check_writable,
    chosen_robots,
    console,
    write_json,
    write_results,
)


class Rival(StrEnum):
    """A published implementation to compare with."""

    RTB = "rtb"


def step(
    robot: Robot = BOTH,
    steps: Annotated[int, typer.Option(help="Smallest number of steps.", min=10)] = 10_000,
    versus: Annotated[
        Rival | None, typer.Option("--vs", help="Also time the published example.")
    ] = None,
    task: Annotated[
        str | None,
        typer.Option(help="Time every control step of a run of this task file or shipped task."),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the goals, or of the run.", min=0)] = 0,
    json: Json = None,
) -> None:
    """Time of one step on the way to seeded goals: ours, the paper's, the published example's."""
    from lab import bench
    from lab.shared import machine

    check_writable(json)
    if task is not None:
        _time_task(robot, find_tree(task), seed, json)
        return
    results = []
    for name in chosen_robots(robot):
        goals = bench.generate_goals(bench.Configuration(robot=name).model(), 100, seed)
        result = bench.time_steps(
            name, goals, steps=steps, against_rtb=versus is Rival.RTB, seed=seed
        )
        results.append(result.with_near(bench.time_near(name, steps=steps // 10, seed=seed)))
    out = console()
    out.print(bench.step_table(results))
    for result in results:
        for line in bench.step_notes(result):
            out.print(line, highlight=False)
    write_results(json, results, {"seed": seed} | machine())


def _time_task(robot: str, tree: Path, seed: int, json: Path | None) -> None:
    """Time the control steps of whole runs, one for every robot."""
    from tempfile import TemporaryDirectory

    from app.core import RunOptions
    from lab import bench
    from lab.shared import machine

    runs = []
    with TemporaryDirectory() as folder:
        for name in chosen_robots(robot):
            options = RunOptions(
                tree=tree, robot=name, seed=seed, record=Path(folder), recording=False
            )
            runs.append(bench.time_run(options))
    out = console()
    out.print(bench.run_steps_table(runs))
    for run in runs:
        for line in bench.run_steps_notes(run):
            out.print(line, highlight=False, soft_wrap=True)
    write_results(json, runs, machine())


def tree(
    rounds: Annotated[int, typer.Option(help="How often to read the file.", min=2)] = 50,
    json: Json = None,
) -> None:
    """Time to read a task file of 200 nodes, and of a tick of a tree of 31 nodes."""
    from lab import bench
    from lab.shared import machine

    check_writable(json)
    timings = bench.time_tree(rounds)
    console().print(bench.tree_table(timings))
    write_results(json, timings, machine())


def perception(
    frames: Annotated[int, typer.Option(help="Frames of an approach.", min=2)] = 60,
    json: Json = None,
) -> None:
    """CPU time of a perception step: in the inference form, and in plain PyTorch."""
    from lab import grasps
    from lab.shared import machine

    check_writable(json)
    result = grasps.measure_perception(frames)
    out = console()
    out.print(grasps.perception_table(result))
    for line in grasps.perception_notes(result):
        out.print(line, highlight=False)
    write_json(json, grasps.perception_json(result, machine()))


def watch(
    tree: Annotated[str, typer.Argument(help="A task file or a shipped task.")] = "pick_place",
    seconds: Annotated[float, typer.Option(help="Of each of the three runs.", min=1.0)] = 60.0,
    json: Json = None,
) -> None:
    """Cost of watching for the loop: nobody watches, a viewer, and a viewer that hangs."""
    from lab import bench
    from lab.shared import progress

    check_writable(json)
    path = find_tree(tree)
    with progress("watch", len(bench.Watcher)) as advance:
        results = bench.measure_watching(path, seconds, lambda: advance(False))
    console().print(bench.watch_table(results))
    write_json(json, bench.watch_json(results))


def start(
    tree: Annotated[str, typer.Argument(help="A task file or a shipped task.")] = "pick_place",
    runs: Annotated[int, typer.Option(help="How often to start it.", min=1)] = 5,
    json: Json = None,
) -> None:
    """Time from `run` to the first words and to the first motion, and that of a `check`."""
    from lab import bench
    from lab.shared import machine

    check_writable(json)
    starts = bench.time_start(find_tree(tree), runs)
    console().print(bench.start_table(starts))
    write_results(json, starts, machine())
