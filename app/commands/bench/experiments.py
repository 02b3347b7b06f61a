"""`bench reach` and `bench poses`: the two experiments of the paper."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.commands.bench.options import (
    BOTH,
    Json,
    Period,
    Robot,
    check_writable,
    chosen_robots,
    console,
    write_json,
)
from app.commands.refuse import refuse

if TYPE_CHECKING:
    from collections.abc import Sequence

    from app.lab import bench


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
    goals: Annotated[
        Path | None, typer.Option(help="An .npz file with poses T (N, 4, 4) instead of a seed.")
    ] = None,
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
    workers: Annotated[
        int | None, typer.Option(help="Processes; default: one per core.", min=1)
    ] = None,
    cluster: Annotated[
        str | None, typer.Option(help="Address of a dask.distributed scheduler to use.")
    ] = None,
    json: Json = None,
) -> None:
    """Experiment 2: reach many goals from rest; count failures, limit violations and contacts."""
    import os
    from math import radians

    from app.lab import bench, machine

    conditions = bench.Conditions(
        limit=limit,
        position_tolerance=tolerance_mm / 1e3,
        orientation_tolerance=radians(tolerance_deg),
        patience=patience,
    )
    workers = workers or os.cpu_count() or 1
    check_writable(json)
    rows = []
    loaded = bench.load_goals(goals) if goals else None
    for name in chosen_robots(robot):
        for speed in _speeds(preset, base_speed):
            for changes in bench.SWEEPS[sweep.value] if sweep else ((),):
                configuration = bench.Configuration(
                    robot=name,
                    preset=preset.value,
                    base_speed=speed,
                    period=period,
                    changes=changes,
                )
                targets = loaded or bench.generate_goals(configuration.model(), count, seed)
                rows.append(_reach(configuration, conditions, targets, workers, cluster))
    out = console()
    out.print(bench.reach_table(rows))
    for line in bench.reach_notes(rows):
        out.print(line, highlight=False)
    about = {"seed": None if goals else seed, "goal_file": str(goals) if goals else None}
    write_json(json, bench.reach_json(rows, about | machine()))


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
    from app.lab import bench, progress

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
    plot: Annotated[
        Path | None, typer.Option(help="Folder for pictures of the motions and curves.")
    ] = None,
    json: Json = None,
) -> None:
    """Experiment 1: the paper's four poses; times, smoothness and manipulability."""
    from math import radians

    from app.lab import bench, machine, progress

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
        bench.Configuration(robot=name, preset=preset.value, base_speed=speed, period=period)
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
                    into.append(bench.run_pose(configuration, name, tolerances, jumps=jumps))
                    advance(into[-1].trial.failure is not None)
    results = [bench.pose_result(run) for run in runs]
    for table in bench.poses_tables(results, [bench.pose_result(run) for run in rivals]):
        console().print(table)
    write_json(json, bench.poses_json(results, {"jumps": jumps} | machine()))
    if plot is not None:
        for path in bench.make_plots(runs, plot):
            console().print(f"wrote {path}", highlight=False)
