"""`bench worlds`: the same seeds in the kinematic and in the physical world."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from app.commands import find_tree
from app.terminal import Terminal
from lab.commands.options import (
    Cluster,
    Json,
    Workers,
    check_writable,
    console,
    seed_range,
    workers_of,
    write_json,
)


def worlds(
    tree: Annotated[str, typer.Argument(help="A task file or a shipped task.")] = "pick_place",
    robot: Annotated[str, typer.Option(help="`frankie`, `omni`, or a robot file.")] = "frankie",
    scene: Annotated[str, typer.Option(help="A shipped scene or a scene file.")] = "household",
    seeds: Annotated[str, typer.Option(help="First and last seed.", metavar="A-B")] = "0-4",
    record: Annotated[Path, typer.Option(help="Folder for the folders of runs.")] = Path("runs"),
    workers: Workers = None,
    cluster: Cluster = None,
    json: Json = None,
) -> None:
    """Run a task in both worlds and compare: objects placed, times, and each grasp."""
    from app.core import RunOptions
    from lab import bench

    wanted = seed_range(seeds)
    check_writable(json)
    options = RunOptions(
        tree=find_tree(tree), robot=robot, scene=scene, record=record, recording=False
    )
    runs = bench.run_in_worlds(
        options,
        wanted,
        lambda summary: summary.show(Terminal(stderr=True)),
        workers=workers_of(workers),
        cluster=cluster,
    )
    console().print(bench.worlds_table(runs))
    for note in bench.worlds_notes(runs):
        console().print(note)
    write_json(json, bench.worlds_json(runs))
