"""`bench pick-place`: the main task over a range of seeds."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from app.commands.bench.options import (
    Cluster,
    Json,
    check_writable,
    console,
    seed_range,
    write_json,
)
from app.commands.refuse import find_tree
from app.terminal import Terminal


def pick_place(
    tree: Annotated[str, typer.Argument(help="A task file or a shipped task.")] = "pick_place",
    robot: Annotated[str, typer.Option(help="`frankie`, `omni`, or a robot file.")] = "frankie",
    world: Annotated[str, typer.Option(help="`kinematic` or `physics`.")] = "kinematic",
    scene: Annotated[str, typer.Option(help="A shipped scene or a scene file.")] = "household",
    seeds: Annotated[str, typer.Option(help="First and last seed.", metavar="A-B")] = "0-4",
    record: Annotated[Path, typer.Option(help="Folder for the folders of runs.")] = Path("runs"),
    workers: Annotated[
        int,
        typer.Option(help="Processes; on busy cores the times of ticks say little.", min=1),
    ] = 1,
    cluster: Cluster = None,
    json: Json = None,
) -> None:
    """Run the main task for several seeds and print a row for each."""
    from app.core import RunOptions
    from app.lab import bench

    wanted = seed_range(seeds)
    check_writable(json)
    options = RunOptions(tree=find_tree(tree), robot=robot, world=world, scene=scene, record=record)
    summaries = bench.run_pick_place(
        options,
        wanted,
        lambda summary: summary.show(Terminal(stderr=True)),
        workers=workers,
        cluster=cluster,
    )
    console().print(bench.pick_place_table(summaries))
    write_json(json, bench.pick_place_json(summaries))
