"""`bench pick-place`: Experiment 3, the main task over a range of seeds."""

from __future__ import annotations

from dataclasses import asdict
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.commands import find_tree
from app.terminal import Terminal
from lab.commands.options import (
    BaseSpeed,
    Cluster,
    Json,
    ReverseSpeed,
    Workers,
    check_writable,
    console,
    seed_range,
    workers_of,
    write_json,
)

if TYPE_CHECKING:
    from app.core import Summary


class Motions(StrEnum):
    """How the robot gets to its goals."""

    HOLISTIC = "holistic"
    PLANNING = "planning"
    BOTH = "both"


def pick_place(
    tree: Annotated[str, typer.Argument(help="A task file or a shipped task.")] = "pick_place",
    robot: Annotated[str, typer.Option(help="`frankie`, `omni`, or a robot file.")] = "frankie",
    world: Annotated[str, typer.Option(help="`kinematic` or `physics`.")] = "kinematic",
    scene: Annotated[str, typer.Option(help="A shipped scene or a scene file.")] = "household",
    motion: Annotated[
        Motions, typer.Option(help="Base and arm as one, by plans as the baseline, or both.")
    ] = Motions.HOLISTIC,
    planning_time: Annotated[
        float, typer.Option(help="By plans: stand so long for each plan [s].", min=0)
    ] = 0.05,
    base_speed: BaseSpeed = None,
    reverse_speed: ReverseSpeed = None,
    seeds: Annotated[
        str, typer.Option(help="First and last seed; a run for each.", metavar="A-B")
    ] = "0-9",
    record: Annotated[Path, typer.Option(help="Folder for the folders of runs.")] = Path("runs"),
    workers: Workers = None,
    cluster: Cluster = None,
    json: Json = None,
    plot: Annotated[Path | None, typer.Option(help="Draw pictures into this folder.")] = None,
) -> None:
    """Run the main task for several seeds, and print Table IV beside the paper's figures."""
    from app.core import MotionForm, RunOptions
    from controller import planning_library
    from lab import bench

    wanted = seed_range(seeds)
    check_writable(json)
    motions = [form for form in MotionForm if motion is Motions.BOTH or form.value == motion.value]
    if MotionForm.PLANNING in motions:
        planning_library()  # what is missing is said before anything runs
    if plot is not None:
        bench.prepare_plots(plot)
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
    number, ended = len(wanted) * len(motions), 0

    def done(summary: Summary) -> None:
        nonlocal ended
        ended += 1
        summary.show(Terminal(stderr=True))
        Terminal(stderr=True).say(f"{ended} of {number} runs done")

    runs = bench.run_pick_place(
        options, wanted, done, motions=motions, workers=workers_of(workers), cluster=cluster
    )
    figures = bench.pick_place_figures(runs)
    console().print(bench.pick_place_table(runs))
    console().print(bench.table_iv(figures))
    for note in bench.pick_place_notes(figures):
        console().say(note)
    write_json(json, bench.pick_place_json(runs, [asdict(one) for one in figures]))
    if plot is not None:
        for file in bench.plot_pick_place(runs, plot):
            console().say(str(file))
