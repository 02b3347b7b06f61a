"""`bench choosing`, `bench counting` and `bench kinds`: what is told apart, and what is taken."""

from __future__ import annotations

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
    write_json,
)


def choosing(
    seeds: Annotated[str, typer.Option(help="First and last seed.", metavar="A-B")] = "0-199",
    world: Annotated[str, typer.Option(help="`kinematic` or `physics`.")] = "kinematic",
    workers: Workers = None,
    cluster: Cluster = None,
    json: Json = None,
) -> None:
    """Ask for the largest, nearest, red, ... of 5 to 8 objects, and see which one is taken."""
    from lab import bench

    wanted = seed_range(seeds)
    check_writable(json)
    told = Terminal(stderr=True)

    def done(taking: bench.Taking) -> None:
        right = "right" if taking.is_right else f"took {taking.taken or 'nothing'}"
        told.print(f"seed {taking.seed}, {taking.clutter}, {taking.asked}: {right}")

    takings = bench.run_choosing(
        wanted, done, world=world, workers=workers_of(workers), cluster=cluster
    )
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
    from lab import bench

    called = bench.run_kinds(seed_range(seeds), workers=workers_of(workers), cluster=cluster)
    console().print(bench.kinds_table(called))


def counting(
    seeds: Annotated[str, typer.Option(help="First and last seed.", metavar="A-B")] = "0-209",
    workers: Workers = None,
    cluster: Cluster = None,
) -> None:
    """Are the objects of a region told apart, also where they touch? In one frame of each scene."""
    from lab import bench

    counted = bench.run_counting(seed_range(seeds), workers=workers_of(workers), cluster=cluster)
    console().print(bench.counting_table(counted))
