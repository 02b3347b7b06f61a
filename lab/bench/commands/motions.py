"""`bench reach`, `poses`, `moving`: the controller's experiments of the paper; and `obstacles`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

import typer

from app.commands import refuse
from lab.bench.commands.bench_options import (
    BOTH,
    Cluster,
    Json,
    Period,
    ReverseSpeed,
    Robot,
    Workers,
    check_writable,
    chosen,
    chosen_robots,
    show,
    write_results,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pinocchio import SE3

    from lab.bench.configuration import Configuration
    from lab.bench.reaching import Conditions, Reach


Preset = Literal["frankie", "paper", "example", "mink", "pink", "rtb"]  # what to measure
Sweep = Literal["heading", "manipulability"]  # the setting to vary
PresetOption = Annotated[
    Preset,
    typer.Option(
        help="frankie: ours; paper: as published; example: its published code; or a peer."
    ),
]
Speeds = Annotated[
    list[float] | None,
    typer.Option("--base-speed", help="Limit of the base in m/s; may be repeated.", min=0.05),
]
ToleranceMm = Annotated[float, typer.Option(help="Tolerance of the position.", min=0.01)]
ToleranceDeg = Annotated[float, typer.Option(help="Tolerance of the orientation.", min=0.01)]


def reach(
    robot: Robot = BOTH,
    preset: PresetOption = "frankie",
    base_speed: Speeds = None,
    reverse_speed: ReverseSpeed = None,
    starts: Annotated[
        str, typer.Option(help="Of the arm: ready, random, limits, singular or stretched.")
    ] = "ready",
    jitter_ms: Annotated[
        str | None,
        typer.Option(
            metavar="<from-to>",
            help="True duration of a period, as 5-30; the controller assumes --period.",
        ),
    ] = None,
    count: Annotated[int, typer.Option(help="Number of seeded goals.", min=1)] = 1000,
    seed: Annotated[int, typer.Option(help="Seed of the goals.", min=0)] = 0,
    limit: Annotated[float, typer.Option(help="Longest time per goal in seconds.", min=0.1)] = 20.0,
    tolerance_mm: ToleranceMm = 10.0,
    tolerance_deg: ToleranceDeg = 1.0,
    sweep: Annotated[Sweep | None, typer.Option(help="Vary a setting of the preset.")] = None,
    period: Period = 0.01,
    workers: Workers = None,
    cluster: Cluster = None,
    json: Json = None,
) -> None:
    """Experiment 2: reach many goals from rest; count failures, limit violations and contacts."""
    from math import radians

    from lab.bench.configuration import Configuration
    from lab.bench.goals import STARTS, generate_goals
    from lab.bench.reaching import SWEEPS, Conditions, reach_notes, reach_table

    chosen("--starts", [starts], STARTS)
    conditions = Conditions(
        starts=starts,
        seed=seed,
        jitter=_parse_jitter(jitter_ms),
        limit=limit,
        position_tolerance=tolerance_mm / 1e3,
        orientation_tolerance=radians(tolerance_deg),
    )
    check_writable(json)
    speeds: Sequence[float | None] = base_speed or ([1.0, 1.5] if preset == "frankie" else [None])
    rows = []
    for name in chosen_robots(robot):
        for speed in speeds:
            for changes in SWEEPS[sweep] if sweep else ((),):
                configuration = Configuration(
                    robot=name,
                    preset=preset,
                    base_speed=speed,
                    reverse_speed=reverse_speed,
                    period=period,
                    changes=changes,
                )
                targets = generate_goals(configuration.model(), count, seed)
                rows.append(_reach(configuration, conditions, targets, cluster or workers))
    show(reach_table(rows), *reach_notes(rows))
    write_results(json, rows, seed=seed)


def _parse_jitter(given: str | None) -> tuple[float, float] | None:
    """Shortest and longest period [s], from milliseconds as in `5-30`."""
    if given is None:
        return None
    first, _, last = given.partition("-")
    try:
        shortest, longest = float(first) / 1e3, float(last) / 1e3
    except ValueError:
        shortest = longest = 0.0
    if not 0.0 < shortest <= longest <= 1.0:
        refuse(f"--jitter-ms {given}: give the shortest and the longest period, as 5-30")
    return shortest, longest


def _reach(
    configuration: Configuration,
    conditions: Conditions,
    goals: Sequence[SE3],
    workers: int | str | None,
) -> Reach:
    from lab.bench.reaching import aggregate_trials, run_trials
    from lab.shared import progress

    speed = configuration.model().limits.base_twist[0]
    name = f"{configuration.robot} {configuration.preset} {speed:.1f} m/s"
    with progress(name, len(goals)) as advance:
        trials = run_trials(
            configuration, conditions, goals, lambda one: advance(one.failure is not None), workers
        )
    return aggregate_trials(configuration, conditions, trials)


def poses(
    robot: Robot = BOTH,
    preset: PresetOption = "frankie",
    base_speed: Speeds = None,
    reverse_speed: ReverseSpeed = None,
    pose: Annotated[
        list[str] | None, typer.Option(help="a, b, c or d; may be repeated; default: all.")
    ] = None,
    tolerance_mm: ToleranceMm = 10.0,
    tolerance_deg: ToleranceDeg = 1.0,
    period: Period = 0.01,
    json: Json = None,
) -> None:
    """Experiment 1: the paper's four poses; times, smoothness and manipulability."""
    from math import radians

    from lab.bench.configuration import EXAMPLE, Configuration
    from lab.bench.poses import POSES, poses_tables, run_pose
    from lab.shared import progress

    check_writable(json)
    names = chosen("--pose", pose, POSES)
    tolerances = (tolerance_mm / 1e3, radians(tolerance_deg))
    robots = chosen_robots(robot)
    speeds: Sequence[float | None] = base_speed or [1.5 if preset == "frankie" else None]
    ours = [
        Configuration(
            robot=name,
            preset=preset,
            base_speed=speed,
            reverse_speed=reverse_speed,
            period=period,
        )
        for name in robots
        for speed in speeds
    ]
    examples = [Configuration(robot=name, preset=EXAMPLE, period=period) for name in robots]
    results = []
    with progress("poses", (len(ours) + len(examples)) * len(names)) as advance:
        for configuration in (*ours, *examples):
            for name in names:
                result = run_pose(configuration, name, tolerances)
                results.append(result)
                advance(result.time_s is None)
    split = len(ours) * len(names)
    show(*poses_tables(results[:split], results[split:]))
    write_results(json, results[:split])


def moving(
    robot: Robot = BOTH, workers: Workers = None, cluster: Cluster = None, json: Json = None
) -> None:
    """Follow goals at 0.3 m/s that never stop: largest errors after catching up."""
    from lab.bench.configuration import Configuration
    from lab.bench.moving_goals import PATHS, Following, moving_table, run_following

    check_writable(json)
    followings = [Following(path=path, known=known) for path in PATHS for known in (True, False)]
    rows = []
    for name in chosen_robots(robot):
        configuration = Configuration(robot=name, base_speed=1.0)
        rows += run_following(configuration, followings, cluster or workers)
    show(moving_table(rows))
    write_results(json, rows)


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
    cluster: Cluster = None,
    json: Json = None,
) -> None:
    """Reach goals among furniture and walkers; count failures and contacts, compare the times."""
    from lab.bench.obstacles.obstacle_report import obstacle_notes, obstacle_rows, obstacle_table
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
                setup, names, lambda world: advance(world[0].reason is not None), cluster or workers
            )
        rows += obstacle_rows(setup, trials)
    show(obstacle_table(rows), *obstacle_notes(rows))
    write_results(json, rows, seed=seed)


def _world(text: str) -> tuple[str, int]:
    from lab.bench.obstacles.obstacle_worlds import FAMILIES

    family, _, number = text.partition(":")
    if family not in FAMILIES or not number.isdigit():
        listed = ", ".join(FAMILIES)
        refuse(f"--only {text}: give family and number such as shelf:3; families: {listed}")
    return family, int(number)
