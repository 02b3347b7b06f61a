"""`bench pick-place`, `on-the-move`, `uncertainty` and `faults`: whole tasks."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Literal

import typer

from app.choices import RegistrationForm
from app.commands import find_tree
from lab.bench.commands.bench_options import (
    Cluster,
    Json,
    OneRobot,
    Record,
    ReverseSpeed,
    Seeds,
    Workers,
    World,
    announcing,
    check_writable,
    chosen,
    seed_range,
    show,
    write_json,
    write_results,
)

Motions = Literal["holistic", "planning", "both"]  # the motion forms to compare
Level = Annotated[
    str,
    typer.Option(
        "--localisation",
        help="How wrong the robot is about where it is: exact (as the paper), good, poor, a file.",
    ),
]


def pick_place(
    tree: Annotated[str, typer.Argument(help="A task file or a shipped task.")] = "pick_place",
    robot: OneRobot = "frankie",
    world: World = "kinematic",
    scene: Annotated[str, typer.Option(help="A shipped scene or a scene file.")] = "household",
    motion: Annotated[
        Motions, typer.Option(help="Base and arm as one, by plans as the baseline, or both.")
    ] = "holistic",
    base_speed: Annotated[
        float | None, typer.Option(help="Limit of the base in m/s; default: the robot's.", min=0.05)
    ] = None,
    reverse_speed: ReverseSpeed = None,
    localisation: Level = "good",
    seeds: Seeds = "0-9",
    record: Record = Path("runs"),
    workers: Workers = None,
    cluster: Cluster = None,
    json: Json = None,
) -> None:
    """Run the main task for several seeds, and print Table IV beside the paper's figures."""
    from app.core import RunOptions
    from lab.bench import pick_place as bench
    from lab.bench.planning import planning_library

    wanted = seed_range(seeds)
    check_writable(json)
    motions = [one for one in bench.MOTIONS if motion in ("both", one)]
    if "planning" in motions:
        planning_library()  # a missing extra is reported before anything runs
    options = RunOptions(
        tree=find_tree(tree),
        robot=robot,
        world=world,
        scene=scene,
        base_speed=base_speed,
        reverse_speed=reverse_speed,
        localisation=localisation,
        record=record,
    )
    done = announcing(len(wanted) * len(motions))
    runs = bench.run_pick_place(options, wanted, done, motions=motions, workers=cluster or workers)
    figures = bench.pick_place_figures(runs)
    show(bench.table_iv(figures), *bench.pick_place_notes(figures))
    summaries = [asdict(run.summary) | {"motion": run.motion} for run in runs]
    write_results(json, figures, runs=summaries)


def on_the_move(
    robot: OneRobot = "frankie",
    world: World = "kinematic",
    scene: Annotated[str, typer.Option(help="A scene with that layout.")] = "on_the_move",
    localisation: Level = "good",
    seeds: Seeds = "0-39",
    record: Record = Path("runs"),
    workers: Workers = None,
    cluster: Cluster = None,
    json: Json = None,
) -> None:
    """Take an object from a table beside the way, once standing and once while driving on."""
    from app.core import RunOptions
    from lab.bench import on_the_move as bench

    wanted = seed_range(seeds)
    check_writable(json)
    options = RunOptions(
        tree=Path(),
        robot=robot,
        world=world,
        scene=scene,
        localisation=localisation,
        record=record,
        recording=False,
    )
    done = announcing(2 * len(wanted))
    runs = bench.run_on_the_move(options, wanted, done, workers=cluster or workers)
    figures, saved = bench.passing_figures(runs), bench.saving(runs)
    show(bench.on_the_move_table(figures))
    if saved is not None:
        low, high = saved.interval
        show(
            f"in passing saves {100 * saved.share:.1f} % ({100 * low:.1f} to {100 * high:.1f}) of "
            f"the time, over {saved.pairs} objects"
        )
    ways = [asdict(of_way) for of_way in figures]
    write_results(json, runs, ways=ways, saving=None if saved is None else asdict(saved))


def uncertainty(
    tree: Annotated[str, typer.Argument(help="A task file or a shipped task.")] = "pick_place",
    robot: OneRobot = "frankie",
    world: World = "kinematic",
    scenes: Annotated[
        list[str] | None, typer.Option("--scene", help="A scene; may be repeated.")
    ] = None,
    levels: Annotated[
        list[str] | None,
        typer.Option("--localisation", help="A level, or the file of one; may be repeated."),
    ] = None,
    registrations: Annotated[
        list[RegistrationForm] | None,
        typer.Option("--registration", help="What is matched to the map; may be repeated."),
    ] = None,
    seeds: Seeds = "0-9",
    record: Record = Path("runs"),
    workers: Workers = None,
    cluster: Cluster = None,
    json: Json = None,
) -> None:
    """Run a task with a robot that is wrong about where it is."""
    from app.core import RunOptions
    from lab.bench import uncertainty as bench

    wanted = seed_range(seeds)
    check_writable(json)
    levels = levels or ["exact", "good", "poor"]
    forms = [form.value for form in registrations or [RegistrationForm.BOTH]]
    scenes = scenes or ["household", "kitchen", "corridor"]
    options = RunOptions(
        tree=find_tree(tree), robot=robot, world=world, record=record, recording=False
    )
    rows = len(levels) * len(forms) - levels.count("exact") * (len(forms) - 1)
    done = announcing(rows * len(scenes) * len(wanted))
    runs = bench.run_uncertainty(
        options, levels, forms, scenes, wanted, done, workers=cluster or workers
    )
    figures = bench.uncertainty_figures(runs)
    show(bench.uncertainty_table(figures))
    write_results(json, figures, runs=[asdict(run.summary) for run in runs])


Names = Annotated[list[str] | None, typer.Option(help="Only this one; may be repeated.")]


def faults(
    faults: Names = None,
    phases: Names = None,
    world: World = "kinematic",
    seeds: Seeds = "1-1",
    quick: Annotated[
        bool, typer.Option("--quick", help="A few faults in two phases, in some seconds.")
    ] = False,
    workers: Annotated[int, typer.Option(help="Processes.", min=1)] = 2,
    json: Json = None,
) -> None:
    """Inject every fault in every phase of a task; the simulated world is the judge."""
    from extensions.faults import PHASES
    from lab.bench import faults as bench
    from lab.bench.fault_matrix import FAULTS, QUICK, QUICK_PHASES
    from lab.shared import progress, run_in_order

    check_writable(json)
    if quick:
        faults, phases = faults or list(QUICK), phases or list(QUICK_PHASES)
    rows = chosen("--faults", faults, [fault.name for fault in FAULTS])
    cells = bench.cells(rows, chosen("--phases", phases, PHASES), seed_range(seeds), world)
    with progress("faults", len(cells)) as advance:
        results = run_in_order(
            bench.run_cell,
            cells,
            lambda one: advance(one.wrong_success or one.hang or one.crash),
            workers=workers,
        )
    show(bench.faults_table(results), *bench.faults_notes(results))
    write_json(json, {"cells": [asdict(one) for one in results]})


def untruth(
    only: Names = None,
    localisation: Level = "good",
    world: World = "kinematic",
    seeds: Seeds = "1-1",
    workers: Annotated[int, typer.Option(help="Processes.", min=1)] = 2,
    json: Json = None,
) -> None:
    """Stage what people and things do to a task, and judge by the world what the robot says."""
    from lab.bench import untruth as bench
    from lab.bench.untruth_cases import CASES
    from lab.shared import progress, run_in_order

    check_writable(json)
    names = chosen("--only", only, [case.name for case in CASES])
    runs = [
        bench.Staging(case=name, world=world, localisation=localisation, seed=seed)
        for name in names
        for seed in seed_range(seeds)
    ]
    with progress("untruth", len(runs)) as advance:
        results = run_in_order(
            bench.run_staging, runs, lambda one: advance(one.is_wrong), workers=workers
        )
    show(bench.untruth_table(results), *bench.untruth_notes(results))
    write_results(json, results)
