"""`bench reach` and `bench poses`: the two experiments of the paper."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.commands import refuse
from lab.commands.jitter import parse_jitter
from lab.commands.options import (
    BOTH,
    Cluster,
    Json,
    Period,
    ReverseSpeed,
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


class Preset(StrEnum):
    """The controller to measure."""

    FRANKIE = "frankie"
    """Ours."""
    PAPER = "paper"
    """The published one."""
    EXAMPLE = "example"
    """The published one, its velocities scaled as in its published example."""


class Sweep(StrEnum):
    """The setting to vary."""

    HEADING = "heading"
    MANIPULABILITY = "manipulability"


PresetOption = Annotated[
    Preset, typer.Option(help="frankie: ours; paper: as published; example: its published code.")
]
Speeds = Annotated[
    list[float] | None,
    typer.Option("--base-speed", help="Limit of the base in m/s; may be repeated.", min=0.05),
]


def reach(
    robot: Robot = BOTH,
    preset: PresetOption = Preset.FRANKIE,
    base_speed: Speeds = None,
    reverse_speed: ReverseSpeed = None,
    goals: Annotated[
        str,
        typer.Option(
            help="anywhere, near, far, floor or above (the base), drawn with a seed; or an .npz"
            " file with poses T (N, 4, 4)."
        ),
    ] = "anywhere",
    starts: Annotated[
        str, typer.Option(help="Of the arm: ready, random, limits, singular or stretched.")
    ] = "ready",
    noise: Annotated[
        bool, typer.Option("--noise", help="The state is off by 1 mrad, 5 mm and 0.3 degrees.")
    ] = False,
    delay_ms: Annotated[
        float, typer.Option(help="From a state to its command.", min=0.0, max=200.0)
    ] = 0.0,
    jitter_ms: Annotated[
        str | None,
        typer.Option(
            metavar="<from-to>",
            help="What a period really lasts, as 5-30; the controller takes it for --period.",
        ),
    ] = None,
    chain: Annotated[
        int, typer.Option(help="Goals to approach one after another, without a stop.", min=1)
    ] = 1,
    count: Annotated[int, typer.Option(help="Number of seeded goals.", min=1)] = 1000,
    seed: Annotated[int, typer.Option(help="Seed of the goals.", min=0)] = 0,
    limit: Annotated[float, typer.Option(help="Longest time per goal in seconds.", min=0.1)] = 20.0,
    patience: Annotated[
        float,
        typer.Option(help="A goal fails after this long without progress, in seconds.", min=0.1),
    ] = 15.0,
    tolerance_mm: Annotated[
        float, typer.Option(help="Tolerance of the position.", min=0.01)
    ] = 10.0,
    tolerance_deg: Annotated[
        float, typer.Option(help="Tolerance of the orientation.", min=0.01)
    ] = 1.0,
    sweep: Annotated[Sweep | None, typer.Option(help="Vary a setting of the preset.")] = None,
    period: Period = 0.01,
    workers: Workers = None,
    cluster: Cluster = None,
    json: Json = None,
) -> None:
    """Experiment 2: reach many goals from rest; count failures, limit violations and contacts."""
    from dataclasses import replace
    from math import radians

    from config import suggest
    from lab import bench
    from lab.shared import machine

    if starts not in bench.STARTS:
        refuse(f"--starts {starts}: no such start; {suggest(starts, bench.STARTS)}")
    disturbance = bench.NOISY if noise else bench.Disturbance()
    conditions = bench.Conditions(
        starts=starts,
        disturbance=replace(disturbance, delay=delay_ms / 1e3),
        seed=seed,
        chain=chain,
        jitter=parse_jitter(jitter_ms),
        limit=limit,
        position_tolerance=tolerance_mm / 1e3,
        orientation_tolerance=radians(tolerance_deg),
        patience=patience,
    )
    workers = workers_of(workers)
    check_writable(json)
    rows = []
    drawn = goals in bench.PLACES
    loaded = None if drawn else bench.load_goals(Path(goals))
    for name in chosen_robots(robot):
        for speed in _speeds(preset, base_speed):
            for changes in bench.SWEEPS[sweep.value] if sweep else ((),):
                configuration = bench.Configuration(
                    robot=name,
                    preset=preset.value,
                    base_speed=speed,
                    reverse_speed=reverse_speed,
                    period=period,
                    changes=changes,
                )
                targets = loaded or bench.generate_goals(configuration.model(), count, seed, goals)
                rows.append(_reach(configuration, conditions, targets, workers, cluster))
    out = console()
    out.print(bench.reach_table(rows))
    for line in bench.reach_notes(rows):
        out.print(line, highlight=False)
    about = {"seed": seed if drawn else None, "goals": goals}
    write_results(json, rows, about | machine())


def _speeds(preset: Preset, speeds: list[float] | None) -> Sequence[float | None]:
    if speeds:
        return speeds
    return (1.0, 1.5) if preset is Preset.FRANKIE else (None,)


def _reach(
    configuration: bench.Configuration,
    conditions: bench.Conditions,
    goals: Sequence[object],
    workers: int,
    cluster: str | None,
) -> bench.Reach:
    from lab import bench
    from lab.shared import progress

    name = f"{configuration.robot} {configuration.preset} {configuration.speed_text} m/s"
    done = {}
    with progress(name, len(goals)) as advance:
        for number, trial in bench.run_trials(
            configuration, conditions, goals, workers=workers, cluster=cluster
        ):
            done[number] = trial
            advance(trial.failure is not None)
    return bench.aggregate_trials(
        configuration, conditions, [done[number] for number in sorted(done)]
    )


def poses(
    robot: Robot = BOTH,
    preset: PresetOption = Preset.FRANKIE,
    base_speed: Speeds = None,
    reverse_speed: ReverseSpeed = None,
    pose: Annotated[
        list[str] | None, typer.Option(help="a, b, c or d; may be repeated; default: all.")
    ] = None,
    tolerance_mm: Annotated[
        float, typer.Option(help="Tolerance of the position.", min=0.01)
    ] = 10.0,
    tolerance_deg: Annotated[
        float, typer.Option(help="Tolerance of the orientation.", min=0.01)
    ] = 1.0,
    period: Period = 0.01,
    jumps: Annotated[
        bool, typer.Option("--jumps", help="Let the velocity of the goal of d jump.")
    ] = False,
    told: Annotated[
        bool, typer.Option("--told", help="Tell the controller the velocity of the goal of d.")
    ] = False,
    plot: Annotated[
        Path | None, typer.Option(help="Folder for pictures of the motions and curves.")
    ] = None,
    json: Json = None,
) -> None:
    """Experiment 1: the paper's four poses; times, smoothness and manipulability."""
    from math import radians

    from lab import bench
    from lab.shared import machine, progress

    check_writable(json)
    chosen = tuple(pose or bench.POSES)
    for name in chosen:
        if name not in bench.POSES:
            refuse(f"--pose {name}: the poses are {', '.join(bench.POSES)}")
    if plot is not None:
        bench.prepare_plots(plot)
    tolerances = (tolerance_mm / 1e3, radians(tolerance_deg))
    robots = chosen_robots(robot)
    speeds: Sequence[float | None] = base_speed or [1.5 if preset is Preset.FRANKIE else None]
    ours = [
        bench.Configuration(
            robot=name,
            preset=preset.value,
            base_speed=speed,
            reverse_speed=reverse_speed,
            period=period,
        )
        for name in robots
        for speed in speeds
    ]
    examples = [
        bench.Configuration(robot=name, preset=bench.EXAMPLE, period=period) for name in robots
    ]
    runs: list[bench.PoseRun] = []
    rivals: list[bench.PoseRun] = []
    with progress("poses", (len(ours) + len(examples)) * len(chosen)) as advance:
        for configurations, into in ((ours, runs), (examples, rivals)):
            for configuration in configurations:
                for name in chosen:
                    run = bench.run_pose(configuration, name, tolerances, jumps=jumps, told=told)
                    into.append(run)
                    advance(into[-1].trial.failure is not None)
    results = [bench.pose_result(run) for run in runs]
    for table in bench.poses_tables(results, [bench.pose_result(run) for run in rivals]):
        console().print(table)
    write_results(json, results, {"jumps": jumps} | machine())
    if plot is not None:
        for path in bench.make_plots(runs, plot):
            console().print(f"wrote {path}", highlight=False)


def moving(
    robot: Robot = BOTH,
    base_speed: Annotated[float, typer.Option(help="Limit of the base in m/s.", min=0.05)] = 1.0,
    speed: Annotated[float, typer.Option(help="Of the goals in m/s.", min=0.01)] = 0.3,
    seed: Annotated[int, typer.Option(help="Seed of the random walk.", min=0)] = 0,
    workers: Workers = None,
    json: Json = None,
) -> None:
    """Follow goals that never stop: largest errors after catching up."""
    from lab import bench
    from lab.shared import machine

    check_writable(json)
    rows = []
    for name in chosen_robots(robot):
        followings = [
            bench.Following(path=path, along=along, known=known, speed=speed, seed=seed)
            for path in bench.PATHS
            for along in (False, True)
            for known in (True, False)
        ]
        configuration = bench.Configuration(robot=name, base_speed=base_speed)
        rows += bench.run_following(configuration, followings, workers_of(workers))
    console().print(bench.moving_table(rows))
    write_results(json, rows, {"seed": seed} | machine())
