"""`bench obstacles`: reaching goals among furniture and walkers."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.commands import refuse
from lab.commands.options import (
    BOTH,
    Cluster,
    Json,
    Period,
    Robot,
    Workers,
    check_writable,
    chosen_robots,
    console,
    workers_of,
    write_results,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lab import bench

_PICTURES = 24
"""Worlds that are drawn at most for each robot."""


def obstacles(
    robot: Robot = BOTH,
    controller: Annotated[
        list[str] | None,
        typer.Option(
            help="frankie, `without guidance`, paper or blind; may be repeated; default: all."
        ),
    ] = None,
    family: Annotated[
        list[str] | None,
        typer.Option(help="room, shelf, table or walkers; may be repeated; default: all."),
    ] = None,
    count: Annotated[int, typer.Option(help="Number of seeded worlds.", min=1)] = 1000,
    seed: Annotated[int, typer.Option(help="Seed of the worlds.", min=0)] = 0,
    only: Annotated[
        list[str] | None,
        typer.Option(help="One of these worlds, such as shelf:3; may be repeated."),
    ] = None,
    base_speed: Annotated[
        float | None, typer.Option(help="Limit of the base in m/s; default: the robot's.", min=0.05)
    ] = None,
    lag: Annotated[
        bool, typer.Option("--lag/--exact", help="Whether the robot lags behind its commands.")
    ] = True,
    limit: Annotated[float, typer.Option(help="Longest time per goal in seconds.", min=0.1)] = 40.0,
    period: Period = 0.01,
    workers: Workers = None,
    cluster: Cluster = None,
    trace: Annotated[
        bool, typer.Option("--trace", help="With --only: print what happens every 0.2 s.")
    ] = False,
    plot: Annotated[
        Path | None,
        typer.Option(help="Folder for pictures of the worlds of --only, or of those that failed."),
    ] = None,
    json: Json = None,
) -> None:
    """Reach goals among furniture and walkers; count failures and contacts, compare the times."""
    from lab import bench
    from lab.shared import machine

    check_writable(json)
    if plot is not None:
        bench.prepare_plots(plot)
    families = _known("--family", family, bench.FAMILIES)
    controllers = _known("--controller", controller, bench.CONTROLLERS)
    names = [_world(one) for one in only] if only else bench.world_names(count, families)
    if trace and not only:
        refuse("--trace: say which world with --only, for example --only shelf:3")
    out = console()
    rows: list[bench.ObstacleRow] = []
    for name in chosen_robots(robot):
        setup = bench.Setup(
            robot=name,
            controllers=controllers,
            base_speed=base_speed,
            period=period,
            lag=lag,
            seed=seed,
            conditions=bench.Conditions(limit=limit),
        )
        done = _run(setup, names, workers_of(workers), cluster)
        rows += bench.obstacle_rows(setup, done)
        if trace:
            for one in names:
                world = bench.make_world(setup, *one)
                for rival in controllers:
                    out.print(f"{name}, {rival}, {world.name}", highlight=False)
                    for line in bench.trace_world(setup, rival, world)[1]:
                        out.print(line, highlight=False, markup=False, soft_wrap=True)
        if plot is not None:
            failed = [
                one
                for one, trials in zip(names, done, strict=True)
                if only or trials[0].reason is not None
            ]
            for path in bench.plot_worlds(setup, failed[:_PICTURES], plot):
                out.print(f"wrote {path}", highlight=False)
    out.print(bench.obstacle_table(rows))
    for line in bench.obstacle_notes(rows):
        out.print(line, highlight=False, markup=False, soft_wrap=True)
    write_results(json, rows, {"seed": seed} | machine())


def _run(
    setup: bench.Setup, names: Sequence[tuple[str, int]], workers: int, cluster: str | None
) -> list[list[bench.WorldTrial]]:
    from lab import bench
    from lab.shared import progress

    done: dict[int, list[bench.WorldTrial]] = {}
    workers = min(workers, len(names))
    with progress(f"{setup.robot} obstacles", len(names)) as advance:
        for number, trials in bench.run_worlds(setup, names, workers=workers, cluster=cluster):
            done[number] = trials
            advance(trials[0].reason is not None)
    return [done[number] for number in sorted(done)]


def _known(option: str, chosen: list[str] | None, known: tuple[str, ...]) -> tuple[str, ...]:
    from config import suggest

    for name in chosen or ():
        if name not in known:
            refuse(f"{option} {name}: there is none; {suggest(name, known)}")
    return tuple(name for name in known if chosen is None or name in chosen)


def _world(text: str) -> tuple[str, int]:
    from lab import bench

    family, _, number = text.partition(":")
    if family not in bench.FAMILIES or not number.isdigit():
        known = ", ".join(bench.FAMILIES)
        refuse(f"--only {text}: give family and number such as shelf:3; families: {known}")
    return family, int(number)
