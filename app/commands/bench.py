"""`frankie-task bench ...`: the command line of the benches."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from app.commands.refuse import find_tree, refuse

if TYPE_CHECKING:
    from collections.abc import Sequence

    from app.lab.bench import Conditions, Configuration, PoseRun, Reach

bench = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Measure: time of a control step and of the tree, the paper's experiments, the main job.",
)


_WIDTH = 120


class RobotChoice(StrEnum):
    """Which robots are measured."""

    FRANKIE = "frankie"
    OMNI = "omni"
    BOTH = "both"


class TaskRobot(StrEnum):
    """Who does the main job, as in `frankie-task run`."""

    FRANKIE = "frankie"
    OMNI = "omni"


class Preset(StrEnum):
    """Whose controller is measured."""

    FRANKIE = "frankie"
    """Ours."""
    PAPER = "paper"
    """The published one."""
    EXAMPLE = "example"
    """The published one, its answer scaled as its published example does."""


class Sweep(StrEnum):
    """Which setting is varied."""

    HEADING = "heading"
    MANIPULABILITY = "manipulability"


class Rival(StrEnum):
    """Whose step is timed beside ours."""

    RTB = "rtb"


_Robot = Annotated[RobotChoice, typer.Option(help="Which robot.")]
_Preset = Annotated[
    Preset, typer.Option(help="frankie: ours; paper: as published; example: its published code.")
]
_Speeds = Annotated[
    list[float] | None,
    typer.Option("--base-speed", help="Limit of the base in m/s; may be repeated.", min=0.05),
]
_Json = Annotated[Path | None, typer.Option("--json", help="Also write the figures here.")]
_Period = Annotated[float, typer.Option(help="Of control, in seconds.", min=0.001, max=0.1)]


def _robots(choice: RobotChoice) -> tuple[str, ...]:
    return ("frankie", "omni") if choice is RobotChoice.BOTH else (choice.value,)


def _speeds(preset: Preset, speeds: list[float] | None) -> Sequence[float | None]:
    if speeds:
        return speeds
    return (1.0, 1.5) if preset is Preset.FRANKIE else (None,)


def _console() -> Console:
    """Standard output; wide enough for a table even if it is not a terminal."""
    console = Console()
    return console if console.is_terminal else Console(width=_WIDTH)


def _check_writable(path: Path | None) -> None:
    """Refuse a file that cannot be written before anything is measured."""
    if path is None:
        return
    try:
        path.open("a", encoding="utf-8").close()
    except OSError as error:
        refuse(f"--json {path}: cannot be written ({error.strerror})")


def _keep(path: Path | None, text: str) -> None:
    if path is not None:
        path.write_text(text + "\n", encoding="utf-8")


@bench.command()
def reach(
    robot: _Robot = RobotChoice.BOTH,
    preset: _Preset = Preset.FRANKIE,
    base_speed: _Speeds = None,
    goals: Annotated[
        Path | None, typer.Option(help="An .npz file with poses T (N, 4, 4) instead of a seed.")
    ] = None,
    count: Annotated[int, typer.Option(help="How many seeded goals.", min=1)] = 1000,
    seed: Annotated[int, typer.Option(help="Of the goals.", min=0)] = 0,
    limit: Annotated[float, typer.Option(help="Longest time in seconds.", min=0.1)] = 20.0,
    patience: Annotated[
        float, typer.Option(help="Given up after this long without progress, in s.", min=0.1)
    ] = 15.0,
    tolerance_mm: Annotated[float, typer.Option(help="Of the position.", min=0.01)] = 10.0,
    tolerance_deg: Annotated[float, typer.Option(help="Of the orientation.", min=0.01)] = 1.0,
    sweep: Annotated[Sweep | None, typer.Option(help="Vary a setting of the preset.")] = None,
    period: _Period = 0.01,
    workers: Annotated[
        int | None, typer.Option(help="Processes; one per core unless said otherwise.", min=1)
    ] = None,
    cluster: Annotated[
        str | None, typer.Option(help="Address of a dask.distributed scheduler to use.")
    ] = None,
    json: _Json = None,
) -> None:
    """Experiment 2: reach many goals from rest; count failures, limits passed and contacts."""
    import os
    from math import radians

    from app.lab.bench import (
        SWEEPS,
        Conditions,
        Configuration,
        generate_goals,
        load_goals,
        reach_json,
        reach_notes,
        reach_table,
    )
    from app.lab.machine import machine

    conditions = Conditions(
        limit=limit,
        position_tolerance=tolerance_mm / 1e3,
        orientation_tolerance=radians(tolerance_deg),
        patience=patience,
    )
    workers = workers or os.cpu_count() or 1
    _check_writable(json)
    rows = []
    given = load_goals(goals) if goals else None
    for name in _robots(robot):
        for speed in _speeds(preset, base_speed):
            for changes in SWEEPS[sweep.value] if sweep else ((),):
                configuration = Configuration(
                    robot=name,
                    preset=preset.value,
                    base_speed=speed,
                    period=period,
                    changes=changes,
                )
                targets = given or generate_goals(configuration.model(), count, seed)
                rows.append(_reach(configuration, conditions, targets, workers, cluster))
    console = _console()
    console.print(reach_table(rows))
    for line in reach_notes(rows):
        console.print(line, highlight=False)
    about = {"seed": None if goals else seed, "goal_file": str(goals) if goals else None}
    _keep(json, reach_json(rows, about | machine()))


def _reach(
    configuration: Configuration,
    conditions: Conditions,
    goals: Sequence[object],
    workers: int,
    cluster: str | None,
) -> Reach:
    from app.lab.bench import aggregate_trials, run_trials
    from app.lab.progress import progress

    name = f"{configuration.robot} {configuration.preset} {configuration.speed_text} m/s"
    done = {}
    with progress(name, len(goals)) as advance:
        for number, trial in run_trials(
            configuration, conditions, goals, workers=workers, cluster=cluster
        ):
            done[number] = trial
            advance(trial.failure is not None)
    return aggregate_trials(configuration, conditions, [done[number] for number in sorted(done)])


@bench.command()
def poses(
    robot: _Robot = RobotChoice.BOTH,
    preset: _Preset = Preset.FRANKIE,
    base_speed: _Speeds = None,
    pose: Annotated[
        list[str] | None, typer.Option(help="a, b, c or d; all unless said otherwise.")
    ] = None,
    tolerance_mm: Annotated[float, typer.Option(help="Of the position.", min=0.01)] = 10.0,
    tolerance_deg: Annotated[float, typer.Option(help="Of the orientation.", min=0.01)] = 1.0,
    period: _Period = 0.01,
    jumps: Annotated[
        bool, typer.Option("--jumps", help="The velocity of the goal of d jumps.")
    ] = False,
    plot: Annotated[
        Path | None, typer.Option(help="Folder for pictures of the motions and curves.")
    ] = None,
    json: _Json = None,
) -> None:
    """Experiment 1: the paper's four poses; times, smoothness and manipulability."""
    from math import radians

    from app.lab.bench import (
        EXAMPLE,
        POSES,
        Configuration,
        make_plots,
        pose_result,
        poses_json,
        poses_tables,
        prepare_plots,
        run_pose,
    )
    from app.lab.machine import machine
    from app.lab.progress import progress

    _check_writable(json)
    wanted = tuple(pose or POSES)
    for name in wanted:
        if name not in POSES:
            refuse(f"--pose {name}: the poses are {', '.join(POSES)}")
    if plot is not None:
        prepare_plots(plot)
    tolerances = (tolerance_mm / 1e3, radians(tolerance_deg))
    speeds: Sequence[float | None] = base_speed or [1.5 if preset is Preset.FRANKIE else None]
    ours = [
        Configuration(robot=name, preset=preset.value, base_speed=speed, period=period)
        for name in _robots(robot)
        for speed in speeds
    ]
    examples = [Configuration(robot=name, preset=EXAMPLE, period=period) for name in _robots(robot)]
    runs: list[PoseRun] = []
    rivals: list[PoseRun] = []
    with progress("poses", (len(ours) + len(examples)) * len(wanted)) as advance:
        for configurations, into in ((ours, runs), (examples, rivals)):
            for configuration in configurations:
                for name in wanted:
                    into.append(run_pose(configuration, name, tolerances, jumps=jumps))
                    advance(into[-1].trial.failure is not None)
    results = [pose_result(run) for run in runs]
    for table in poses_tables(results, [pose_result(run) for run in rivals]):
        _console().print(table)
    _keep(json, poses_json(results, {"jumps": jumps} | machine()))
    if plot is not None:
        for path in make_plots(runs, plot):
            _console().print(f"left {path}", highlight=False)


@bench.command()
def step(
    robot: _Robot = RobotChoice.BOTH,
    steps: Annotated[int, typer.Option(help="How many at least.", min=10)] = 10_000,
    versus: Annotated[
        Rival | None, typer.Option("--vs", help="Also time the published example.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the goals.", min=0)] = 0,
    json: _Json = None,
) -> None:
    """Time of one step on the way to seeded goals: ours, the paper's, the published example's."""
    from app.lab.bench import (
        Configuration,
        generate_goals,
        step_json,
        step_notes,
        step_table,
        time_steps,
    )
    from app.lab.machine import machine

    _check_writable(json)
    results = []
    for name in _robots(robot):
        goals = generate_goals(Configuration(robot=name).model(), 100, seed)
        results.append(
            time_steps(name, goals, steps=steps, against_rtb=versus is Rival.RTB, seed=seed)
        )
    console = _console()
    console.print(step_table(results))
    for result in results:
        for line in step_notes(result):
            console.print(line, highlight=False)
    _keep(json, step_json(results, {"seed": seed} | machine()))


@bench.command("tree")
def bench_tree(
    rounds: Annotated[int, typer.Option(help="How often the file is read.", min=2)] = 50,
    json: _Json = None,
) -> None:
    """Time of reading a task file of 200 nodes, and of a tick of a tree of 31 nodes."""
    from app.lab.bench import time_tree, tree_json, tree_table
    from app.lab.machine import machine

    _check_writable(json)
    timings = time_tree(rounds)
    _console().print(tree_table(timings))
    _keep(json, tree_json(timings, machine()))


@bench.command()
def perception(
    frames: Annotated[int, typer.Option(help="Frames of an approach, seen thrice.", min=2)] = 60,
    json: _Json = None,
) -> None:
    """Processor time of a perception step: as it is used, and in plain PyTorch."""
    from app.lab.grasps.step_time import (
        measure_perception,
        perception_json,
        perception_notes,
        perception_table,
    )
    from app.lab.machine import machine

    _check_writable(json)
    result = measure_perception(frames)
    console = _console()
    console.print(perception_table(result))
    for line in perception_notes(result):
        console.print(line, highlight=False)
    _keep(json, perception_json(result, machine()))


@bench.command("pick-place")
def bench_pick_place(
    tree: Annotated[str, typer.Argument(help="A task file or a shipped task.")] = "pick_place",
    robot: Annotated[TaskRobot, typer.Option(help="Who does it.")] = TaskRobot.FRANKIE,
    scene: Annotated[str, typer.Option(help="A shipped scene or a scene file.")] = "household",
    seeds: Annotated[str, typer.Option(help="First and last seed.", metavar="A-B")] = "0-4",
    record: Annotated[Path, typer.Option(help="Folder for the folders of runs.")] = Path("runs"),
    json_file: Annotated[Path | None, typer.Option("--json", help="Write figures here.")] = None,
) -> None:
    """Run the main job for several seeds and print a row for each."""
    from app.core.launch import RunOptions
    from app.lab.bench import pick_place_json, pick_place_table, run_pick_place

    first, dash, last = seeds.partition("-")
    if not (first.isdigit() and (last.isdigit() or not dash)):
        refuse(f"--seeds {seeds}: give the first and the last seed, for example 0-4")
    _check_writable(json_file)
    options = RunOptions(tree=find_tree(tree), robot=robot.value, scene=scene, record=record)
    summaries = run_pick_place(
        options,
        range(int(first), int(last or first) + 1),
        lambda summary: summary.show(Console(stderr=True)),
    )
    _console().print(pick_place_table(summaries))
    _keep(json_file, pick_place_json(summaries))


@bench.command()
def watch(
    tree: Annotated[str, typer.Argument(help="A task file or a shipped task.")] = "pick_place",
    seconds: Annotated[float, typer.Option(help="Of each of three runs.", min=1.0)] = 60.0,
    json: _Json = None,
) -> None:
    """What watching costs the loop: nobody, a viewer, and a viewer that hangs."""
    from app.lab.bench import Watcher, measure_watching, watch_json, watch_table
    from app.lab.progress import progress

    _check_writable(json)
    path = find_tree(tree)
    with progress("watch", len(Watcher)) as advance:
        results = measure_watching(path, seconds, lambda: advance(False))
    _console().print(watch_table(results))
    _keep(json, watch_json(results))
