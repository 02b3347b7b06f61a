"""`bench obstacles`: reaching goals among furniture and walkers."""

from typing import Annotated

import typer

from app.commands import refuse
from lab.bench.commands.options import (
    BOTH,
    Json,
    Robot,
    Workers,
    check_writable,
    chosen,
    chosen_robots,
    show,
    write_results,
)


def obstacles(
    robot: Robot = BOTH,
    controller: Annotated[
        list[str] | None,
        typer.Option(help="frankie, paper or blind; may be repeated; default: all."),
    ] = None,
    count: Annotated[int, typer.Option(help="Number of seeded worlds.", min=1)] = 1000,
    seed: Annotated[int, typer.Option(help="Seed of the worlds.", min=0)] = 0,
    only: Annotated[
        list[str] | None,
        typer.Option(help="One of these worlds, such as shelf:3; may be repeated."),
    ] = None,
    limit: Annotated[float, typer.Option(help="Longest time per goal in seconds.", min=0.1)] = 40.0,
    workers: Workers = None,
    json: Json = None,
) -> None:
    """Reach goals among furniture and walkers; count failures and contacts, compare the times."""
    from lab.bench.obstacles.report import obstacle_notes, obstacle_rows, obstacle_table
    from lab.bench.obstacles.trials import CONTROLLERS, Setup, run_worlds, world_names
    from lab.shared import progress

    check_writable(json)
    controllers = tuple(chosen("--controller", controller, CONTROLLERS))
    names = [_world(one) for one in only] if only else world_names(count)
    rows = []
    for name in chosen_robots(robot):
        setup = Setup(robot=name, controllers=controllers, seed=seed, limit=limit)
        with progress(f"{name} obstacles", len(names)) as advance:
            trials = run_worlds(
                setup, names, lambda world: advance(world[0].reason is not None), workers
            )
        rows += obstacle_rows(setup, trials)
    show(obstacle_table(rows), *obstacle_notes(rows))
    write_results(json, rows, seed=seed)


def _world(text: str) -> tuple[str, int]:
    from lab.bench.obstacles.worlds import FAMILIES

    family, _, number = text.partition(":")
    if family not in FAMILIES or not number.isdigit():
        listed = ", ".join(FAMILIES)
        refuse(f"--only {text}: give family and number such as shelf:3; families: {listed}")
    return family, int(number)
