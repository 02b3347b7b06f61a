"""`bench on-the-move`: what it saves that the base does not wait for the hand."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from app.terminal import Terminal
from lab.commands.options import (
    Cluster,
    Json,
    Workers,
    check_writable,
    console,
    seed_range,
    workers_of,
    write_results,
)


def on_the_move(
    robot: Annotated[str, typer.Option(help="`frankie`, `omni`, or a robot file.")] = "frankie",
    world: Annotated[str, typer.Option(help="`kinematic` or `physics`.")] = "kinematic",
    scene: Annotated[str, typer.Option(help="A scene with that layout.")] = "on_the_move",
    seeds: Annotated[str, typer.Option(help="First and last seed.", metavar="A-B")] = "0-39",
    record: Annotated[Path, typer.Option(help="Folder for the folders of runs.")] = Path("runs"),
    workers: Workers = None,
    cluster: Cluster = None,
    json: Json = None,
) -> None:
    """Take an object from a table beside the way, once standing and once while driving on."""
    from app.core import RunOptions
    from lab import bench
    from lab.shared import machine

    wanted = seed_range(seeds)
    check_writable(json)
    options = RunOptions(
        tree=Path(), robot=robot, world=world, scene=scene, record=record, recording=False
    )
    number, ended = 2 * len(wanted), 0

    def done(_: object) -> None:
        nonlocal ended
        ended += 1
        Terminal(stderr=True).say(f"{ended} of {number} runs done")

    runs = bench.run_on_the_move(
        options, wanted, done, workers=workers_of(workers), cluster=cluster
    )
    console().print(bench.on_the_move_table(runs))
    saved = bench.saving(runs)
    if saved is not None:
        low, high = saved.interval
        console().say(
            f"in passing saves {100 * saved.share:.1f} % ({100 * low:.1f} to {100 * high:.1f}) of "
            f"the time, over {saved.pairs} objects"
        )
    about = {
        "ways": [asdict(of_way) for of_way in bench.passing_figures(runs)],
        "saving": None if saved is None else asdict(saved),
    } | machine()
    write_results(json, runs, about)
