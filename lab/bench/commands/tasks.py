"""`bench pick-place`, `bench on-the-move` and `bench choosing`: whole tasks over many seeds."""

from __future__ import annotations

from dataclasses import asdict
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.commands import find_tree
from app.terminal import Terminal
from lab.bench.commands.options import (
    Cluster,
    Json,
    OneRobot,
    Record,
    ReverseSpeed,
    Seeds,
    Workers,
    World,
    check_writable,
    counted,
    seed_range,
    show,
    workers_of,
    write_json,
    write_results,
)

if TYPE_CHECKING:
    from lab.bench.choosing import Taking


class Motions(StrEnum):
    """The motion forms to compare."""

    HOLISTIC = "holistic"
    PLANNING = "planning"
    BOTH = "both"


def pick_place(
    tree: Annotated[str, typer.Argument(help="A task file or a shipped task.")] = "pick_place",
    robot: OneRobot = "frankie",
    world: World = "kinematic",
    scene: Annotated[str, typer.Option(help="A shipped scene or a scene file.")] = "household",
    motion: Annotated[
        Motions, typer.Option(help="Base and arm as one, by plans as the baseline, or both.")
    ] = Motions.HOLISTIC,
    planning_time: Annotated[
        float, typer.Option(help="By plans: the time that each plan takes [s].", min=0)
    ] = 0.05,
    base_speed: Annotated[
        float | None, typer.Option(help="Limit of the base in m/s; default: the robot's.", min=0.05)
    ] = None,
    reverse_speed: ReverseSpeed = None,
    seeds: Seeds = "0-9",
    record: Record = Path("runs"),
    workers: Workers = None,
    cluster: Cluster = None,
    json: Json = None,
) -> None:
    """Run the main task for several seeds, and print Table IV beside the paper's figures."""
    from app.core import MotionForm, RunOptions
    from controller import planning_library
    from lab.bench import pick_place as bench

    wanted = seed_range(seeds)
    check_writable(json)
    motions = [form for form in MotionForm if motion is Motions.BOTH or form.value == motion.value]
    if MotionForm.PLANNING in motions:
        planning_library()  # a missing extra is reported before anything runs
    options = RunOptions(
        tree=find_tree(tree),
        robot=robot,
        world=world,
        scene=scene,
        base_speed=base_speed,
        reverse_speed=reverse_speed,
        record=record,
        planning_time=planning_time,
    )
    done = counted(len(wanted) * len(motions))
    runs = bench.run_pick_place(
        options, wanted, done, motions=motions, workers=workers_of(workers, cluster)
    )
    figures = bench.pick_place_figures(runs)
    show(bench.pick_place_table(runs), bench.table_iv(figures), *bench.pick_place_notes(figures))
    summaries = [asdict(run.summary) | {"motion": run.motion} for run in runs]
    write_results(json, figures, runs=summaries)


def on_the_move(
    robot: OneRobot = "frankie",
    world: World = "kinematic",
    scene: Annotated[str, typer.Option(help="A scene with that layout.")] = "on_the_move",
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
        tree=Path(), robot=robot, world=world, scene=scene, record=record, recording=False
    )
    done = counted(2 * len(wanted))
    runs = bench.run_on_the_move(options, wanted, done, workers=workers_of(workers, cluster))
    show(bench.on_the_move_table(runs))
    saved = bench.saving(runs)
    if saved is not None:
        low, high = saved.interval
        show(
            f"in passing saves {100 * saved.share:.1f} % ({100 * low:.1f} to {100 * high:.1f}) of "
            f"the time, over {saved.pairs} objects"
        )
    ways = [asdict(of_way) for of_way in bench.passing_figures(runs)]
    write_results(json, runs, ways=ways, saving=None if saved is None else asdict(saved))


def choosing(
    seeds: Seeds = "0-199",
    world: World = "kinematic",
    workers: Workers = None,
    cluster: Cluster = None,
    json: Json = None,
) -> None:
    """Ask for the largest, nearest, red, ... of 5 to 8 objects, and check which one is taken."""
    from lab.bench import choosing as bench

    wanted = seed_range(seeds)
    check_writable(json)

    def done(taking: Taking) -> None:
        result = "right" if taking.is_right else f"took {taking.taken or 'nothing'}"
        Terminal(stderr=True).print(
            f"seed {taking.seed}, {taking.clutter}, {taking.asked}: {result}"
        )

    takings = bench.run_choosing(wanted, done, world=world, workers=workers_of(workers, cluster))
    show(bench.choosing_table(takings), *bench.choosing_notes(takings))
    write_json(json, {"scenes": [asdict(one) | {"right": one.is_right} for one in takings]})
