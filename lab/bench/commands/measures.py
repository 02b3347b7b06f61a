"""`bench step` and `perception`: times; `bench experiments`: the figures of the documents again."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from app.commands import refuse
from app.terminal import Terminal
from lab.bench.commands.bench_options import (
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


def step(
    robot: Robot = BOTH,
    vs: Annotated[
        str, typer.Option(help="Peers on the same states: rtb, mink, pink, separated by commas.")
    ] = "",
    seed: Annotated[int, typer.Option(help="Seed of the goals.", min=0)] = 0,
    count: Annotated[int, typer.Option(help="Steps.", min=1)] = 10_000,
    json: Json = None,
) -> None:
    """Time a control step on the way to seeded goals, beside the same step of peers."""
    from lab.bench.peers import LACKS
    from lab.bench.step_time import step_table, time_steps

    check_writable(json)
    peers = chosen("--vs", vs.split(",") if vs else [], tuple(LACKS))
    rows = [
        row
        for name in chosen_robots(robot)
        for row in time_steps(name, peers, steps=count, seed=seed)
    ]
    show(step_table(rows))
    write_results(json, rows)


def perception(
    count: Annotated[int, typer.Option(help="Frames.", min=1)] = 60,
    json: Json = None,
) -> None:
    """Time the step from a frame to grasps, and GG-CNN in it: processor time of the thread."""
    from lab.bench.perception_time import perception_table, time_perception

    check_writable(json)
    timings = time_perception(count)
    show(perception_table(timings))
    write_results(json, timings)


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
    from config.reader import read_config
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
