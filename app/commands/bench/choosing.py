"""`bench choosing`: is what was asked for what is taken? `bench kinds`: what are things called?"""

from __future__ import annotations

from typing import Annotated

import typer

from app.commands.bench.options import (
    Cluster,
    Json,
    Workers,
    check_writable,
    console,
    seed_range,
    workers_of,
    write_json,
)
from app.terminal import Terminal


def choosing(
    seeds: Annotated[str, typer.Option(help="First and last seed.", metavar="A-B")] = "0-199",
    workers: Workers = None,
    cluster: Cluster = None,
    json: Json = None,
) -> None:
    """Ask for the largest, nearest, red, ... of 5 to 8 objects, and see which one is taken."""
    from app.lab import bench

    wanted = seed_range(seeds)
    check_writable(json)
    told = Terminal(stderr=True)

    def done(taking: bench.Taking) -> None:
        right = "right" if taking.is_right else f"took {taking.taken or 'nothing'}"
        told.print(f"seed {taking.seed}, {taking.clutter}, {taking.asked}: {right}")

    takings = bench.run_choosing(wanted, done, workers=workers_of(workers), cluster=cluster)
    console().print(bench.choosing_table(takings))
    for note in bench.choosing_notes(takings):
        console().print(note)
    write_json(json, bench.choosing_json(takings))


def kinds(
    seeds: Annotated[str, typer.Option(help="First and last seed.", metavar="A-B")] = "0-399",
    workers: Workers = None,
    cluster: Cluster = None,
) -> None:
    """What the shipped recogniser calls the objects of simulated scenes, in one frame of each."""
    from app.lab import bench

    called = bench.run_kinds(seed_range(seeds), workers=workers_of(workers), cluster=cluster)
    console().print(bench.kinds_table(called))
