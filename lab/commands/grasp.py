"""`frankie-task grasp`: train and evaluate the grasp networks, and show the grasps they find."""

from __future__ import annotations

import os
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from app.commands import refuse
from app.terminal import Terminal


class Judge(StrEnum):
    """Who judges grasps."""

    KINEMATIC = "kinematic"
    PHYSICS = "physics"


class Ranked(StrEnum):
    """What puts one grasp before another."""

    LIKELIHOOD = "likelihood"
    CHECK = "check"
    FIRST = "first"


class Kinds(StrEnum):
    """Of objects, for outcomes."""

    TRAINED = "trained"
    BODIES = "bodies"
    LIGHT = "light"
    HELDOUT = "heldout"


app = typer.Typer(no_args_is_help=True, help="The grasp networks: train, evaluate, show.")


@app.command()
def train(
    recipe: Annotated[str, typer.Argument(help="`bins`, `ggcnn`, or a recipe file.")] = "bins",
    folder: Annotated[
        Path,
        typer.Option(help="For images, checkpoints and weights; an interrupted training resumes."),
    ] = Path("training"),
    workers: Annotated[
        int | None, typer.Option(help="Processes that render; default: one per core.", min=1)
    ] = None,
    device: Annotated[str, typer.Option(help="auto, cpu or cuda.")] = "auto",
) -> None:
    """Render scenes, label every grasp in them, and train a network from scratch."""
    from lab import grasps

    console = Terminal(stderr=True)
    out = grasps.train_weights(
        grasps.read_recipe(recipe),
        folder,
        workers=workers or os.cpu_count() or 1,
        device=device,
        console=console,
    )
    typer.echo(str(out))


@app.command("eval")
def evaluate(
    weights: Annotated[
        Path | None, typer.Option(help="A weights file; default: shipped weights.")
    ] = None,
    network: Annotated[
        str | None,
        typer.Option(
            help="Which shipped network: bins (the default) or ggcnn; or none (points by chance) "
            "or check (points everywhere), to see what the feasibility check does alone."
        ),
    ] = None,
    judge: Annotated[
        Judge,
        typer.Option(help="What decides whether a grasp holds: rules of contact, or rigid bodies."),
    ] = Judge.KINEMATIC,
    ranked: Annotated[
        Ranked | None,
        typer.Option(
            help="With physics: what ranks grasps: how likely they hold (the default with a "
            "network), the check, or the check as in the first version, which looked only once."
        ),
    ] = None,
    scenes: Annotated[
        int, typer.Option(help="With physics: number of scenes of one object.", min=1)
    ] = 500,
    bins: Annotated[int, typer.Option(help="With physics: number of bins of six.", min=0)] = 30,
    meshes: Annotated[
        Path | None, typer.Option(help="With physics: a folder of meshes to take objects from.")
    ] = None,
    against: Annotated[
        Path | None,
        typer.Option(help="With physics: a file that --json wrote before, to compare with."),
    ] = None,
    by_chance: Annotated[
        int,
        typer.Option(
            help="With physics: number of random grasps to try where no row holds the object, "
            "to see whether there is any that holds.",
            min=0,
        ),
    ] = 0,
    images: Annotated[
        int, typer.Option(help="Number of images; half single objects, half clutter.", min=2)
    ] = 1000,
    objects: Annotated[
        int, typer.Option(help="Number of objects to pick in the closed loop.", min=0)
    ] = 304,
    cornell: Annotated[
        Path | None, typer.Option(help="Folder of a data set in the Cornell format.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(help="Processes; default: one per core.", min=1)
    ] = None,
    json: Annotated[Path | None, typer.Option(help="Write all figures to this file.")] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Draw images whose best grasp fails to this file (.png).")
    ] = None,
) -> None:
    """Measure success rates on objects of held-out classes, with confidence intervals."""
    import json as json_format

    from lab import grasps

    if weights is not None and network is not None:
        refuse("--network: the file of --weights determines the network; give one of the two")
    for file in (json, plot):
        if file is not None and not file.parent.is_dir():
            refuse(f"{file}: there is no folder {file.parent}; create it first")
    choice = grasps.NetworkChoice(weights=weights, network=network, ranked=ranked)
    if judge is Judge.PHYSICS:
        if cornell is not None or plot is not None:
            refuse("--judge physics: --cornell and --plot belong to the kinematic judge")
        physical = grasps.evaluate_by_physics(
            choice,
            scenes=scenes,
            bins=bins,
            meshes=meshes,
            against=against,
            by_chance=by_chance,
            workers=workers or os.cpu_count() or 1,
        )
        for table in grasps.physical_tables(physical):
            Terminal().print(table)
        for note in grasps.physical_notes(physical):
            typer.echo(note)
        if json is not None:
            json.write_text(json_format.dumps(physical.to_json(), indent=1), encoding="utf-8")
        return
    if meshes is not None or against is not None or ranked is not None or by_chance:
        refuse("--meshes, --against, --ranked and --by-chance belong to --judge physics")
    evaluation = grasps.evaluate_grasps(
        choice,
        images=images,
        objects=objects,
        cornell=cornell,
        workers=workers or os.cpu_count() or 1,
    )
    Terminal().print(grasps.evaluation_table(evaluation))
    typer.echo(f"perception step: {evaluation.step_median_ms:.1f} ms of one core (median)")
    if json is not None:
        json.write_text(json_format.dumps(evaluation.to_json(), indent=1), encoding="utf-8")
    if plot is not None:
        typer.echo(f"{grasps.draw_failures(choice, evaluation, plot)} failures drawn in {plot}")


@app.command()
def outcomes(
    folder: Annotated[Path, typer.Argument(help="Where scenes are added; what is there stays.")],
    kinds: Annotated[
        Kinds,
        typer.Option(help="Objects to learn from (three sets), or held-out ones to judge by."),
    ] = Kinds.TRAINED,
    scenes: Annotated[int, typer.Option(help="Scenes; every other one is a bin.", min=1)] = 200,
    workers: Annotated[
        int | None, typer.Option(help="Processes; default: one per core.", min=1)
    ] = None,
) -> None:
    """Execute random feasible grasps in physics, and write what was seen and what became of it."""
    from lab import grasps

    console = Terminal(stderr=True)
    for found in grasps.collect_outcomes(
        folder, kinds.value, scenes=scenes, workers=workers or os.cpu_count() or 1
    ):
        good = int(found.good.sum())
        console.say(f"{len(found.good)} more grasps, {good} of them held without a hard contact")


@app.command()
def fit(
    folder: Annotated[Path, typer.Argument(help="Outcomes of `grasp outcomes`.")],
    out: Annotated[Path, typer.Option(help="The weights file to write.")] = Path(
        "hold.safetensors"
    ),
    rounds: Annotated[int, typer.Option(help="Times that every grasp is seen.", min=1)] = 16,
) -> None:
    """Fit the network that tells how likely a grasp holds to the outcomes of learnt objects."""
    from lab import grasps

    grasps.fit_outcomes(folder, out, rounds=rounds, say=Terminal(stderr=True).say)
    typer.echo(str(out))


@app.command()
def probability(
    folder: Annotated[Path, typer.Argument(help="Outcomes, of --kinds heldout.")],
    weights: Annotated[
        Path | None, typer.Option(help="A file of `grasp fit`; default: shipped weights.")
    ] = None,
) -> None:
    """Measure how well a network tells whether a grasp holds, on objects that it never saw."""
    from lab import grasps
    from perception.networks import load_hold, shipped_hold

    gripper = grasps.ROBOT.gripper
    hold = shipped_hold(gripper) if weights is None else load_hold(weights, gripper)
    assert hold is not None, "what is shipped was fitted to this hand"
    judged = grasps.read_outcomes(folder, Kinds.HELDOUT.value)
    Terminal().print(grasps.probability_table(judged, hold))


@app.command()
def views(
    network: Annotated[str | None, typer.Option(help="Which shipped network, or none.")] = None,
    scenes: Annotated[int, typer.Option(help="Scenes of one object.", min=1)] = 60,
    looks: Annotated[
        int,
        typer.Option(help="Looks from above at most, where there is no grasp.", min=0),
    ] = 0,
    workers: Annotated[
        int | None, typer.Option(help="Processes; default: one per core.", min=1)
    ] = None,
) -> None:
    """From the side and from afar: in how many scenes there is a grasp, and it holds in physics."""
    from lab import grasps

    choice = grasps.NetworkChoice(network=network)
    seen = grasps.measure_views(
        choice, scenes=scenes, looks=looks, workers=workers or os.cpu_count() or 1
    )
    Terminal().print(grasps.views_table(seen))
    for note in grasps.views_notes(seen):
        typer.echo(note)


@app.command()
def show(
    image: Annotated[
        Path,
        typer.Argument(
            help="Depth as .npy, .png, .tiff (integer mm or float m), or an .rrd recording."
        ),
    ],
    out: Annotated[
        Path | None, typer.Option(help="The picture to write; default: next to the image.")
    ] = None,
    focal: Annotated[
        float | None, typer.Option(help="Focal length [px]; default: that of a D435.", min=1.0)
    ] = None,
    at: Annotated[
        float | None, typer.Option(help="Time in a recording [s]; default: the last image.")
    ] = None,
    weights: Annotated[Path | None, typer.Option(help="A weights file.")] = None,
    network: Annotated[str | None, typer.Option(help="Which shipped network.")] = None,
) -> None:
    """Find grasps in a depth image of your camera and draw them over it."""
    from lab import grasps
    from perception import GraspDetector

    summary = grasps.show_grasps(
        image,
        out or image.with_name(f"{image.stem}_grasps.png"),
        focal=focal,
        at=at,
        detector=GraspDetector(weights, network, gripper=grasps.ROBOT.gripper),
    )
    typer.echo(summary)
