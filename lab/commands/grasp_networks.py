"""`frankie-task grasp`: train and evaluate the grasp networks, and show the grasps they find."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Literal

import typer

from app.commands import refuse
from app.terminal import Terminal

Kinds = Literal["trained", "bodies", "light", "tilted", "heldout", "heldout_tilted"]
Workers = Annotated[int | None, typer.Option(help="Processes; default: one per core.", min=1)]
OutcomesFolder = Annotated[Path, typer.Argument(help="Folder of `grasp outcomes`.")]

app = typer.Typer(no_args_is_help=True, help="The grasp networks: train, evaluate, show.")


@app.command()
def train(
    recipe: Annotated[
        Path | None, typer.Argument(help="A recipe file; default: that of the shipped weights.")
    ] = None,
    folder: Annotated[
        Path,
        typer.Option(help="For images, checkpoints and weights; an interrupted training resumes."),
    ] = Path("training"),
    workers: Workers = None,
) -> None:
    """Render scenes, label every grasp in them, and train GG-CNN from scratch."""
    from config.reader import read_config
    from lab import grasps

    kind = grasps.TrainingRecipe
    out = grasps.train_weights(
        kind() if recipe is None else read_config(recipe, kind),
        folder,
        workers=workers,
        console=Terminal(stderr=True),
    )
    typer.echo(str(out))


@app.command("eval")
def evaluate(
    weights: Annotated[
        Path | None, typer.Option(help="A weights file; default: the shipped weights.")
    ] = None,
    network: Annotated[
        Literal["none", "check"] | None,
        typer.Option(
            help="Instead of GG-CNN, to see what the feasibility check does alone: random points "
            "(none), or points everywhere (check)."
        ),
    ] = None,
    scenes: Annotated[int, typer.Option(help="Scenes of one object.", min=1)] = 500,
    bins: Annotated[int, typer.Option(help="Bins of six objects.", min=0)] = 30,
    meshes: Annotated[
        Path | None, typer.Option(help="A folder of meshes to take objects from.")
    ] = None,
    by_chance: Annotated[
        int,
        typer.Option(
            help="Random grasps to try where no row holds the object, to see whether any holds.",
            min=0,
        ),
    ] = 0,
    tilts: Annotated[
        str | None,
        typer.Option(
            help="Scenes of one object, each grasped along approaches that are tilted so much from "
            "straight down [deg], instead: 0,30,60,90."
        ),
    ] = None,
    workers: Workers = None,
    json: Annotated[Path | None, typer.Option(help="Write all figures to this file.")] = None,
) -> None:
    """Grasp objects of held-out classes in physics: success rates with confidence intervals."""
    import json as json_format

    from lab import grasps
    from lab.shared import machine

    if weights is not None and network is not None:
        refuse("--network: weights are of GG-CNN; give one of the two")
    if json is not None and not json.parent.is_dir():
        refuse(f"{json}: there is no folder {json.parent}; create it first")
    choice = grasps.NetworkChoice(weights=weights, network=network)
    if tilts is not None:
        if meshes:
            refuse("--tilts: goes without --meshes")
        evaluation = grasps.evaluate_tilts(
            choice, _tilts(tilts), scenes=scenes, by_chance=by_chance, workers=workers
        )
    else:
        evaluation = grasps.evaluate_grasps(
            choice, scenes=scenes, bins=bins, meshes=meshes, by_chance=by_chance, workers=workers
        )
    for table in grasps.evaluation_tables(evaluation):
        Terminal().print(table)
    for note in grasps.evaluation_notes(evaluation):
        typer.echo(note)
    if json is not None:
        figures = asdict(evaluation) | machine()
        json.write_text(json_format.dumps(figures, indent=1), encoding="utf-8")


def _tilts(text: str) -> list[float]:
    """Angles of a list in degrees."""
    try:
        tilts = [float(each) for each in text.split(",")]
    except ValueError:
        tilts = []
    if not tilts or not all(0.0 <= tilt <= 90.0 for tilt in tilts):
        refuse(f"--tilts {text}: not angles of 0 to 90 degrees, like 0,30,60,90")
    return tilts


@app.command()
def outcomes(
    folder: Annotated[Path, typer.Argument(help="Where scenes are added; what is there stays.")],
    kinds: Annotated[
        Kinds,
        typer.Option(help="Objects to learn from (four sets), or held-out ones to judge by."),
    ] = "trained",
    scenes: Annotated[int, typer.Option(help="Scenes; every other one is a bin.", min=1)] = 200,
    workers: Workers = None,
) -> None:
    """Execute random feasible grasps in physics, and write their depth patches and outcomes."""
    from lab import grasps

    console = Terminal(stderr=True)
    for found in grasps.collect_outcomes(folder, kinds, scenes=scenes, workers=workers):
        good = int(found.good.sum())
        console.say(f"{len(found.good)} more grasps, {good} of them held without a hard contact")


@app.command()
def fit(
    folder: OutcomesFolder,
    out: Annotated[Path, typer.Option(help="The weights file to write.")] = Path(
        "hold.safetensors"
    ),
    rounds: Annotated[int, typer.Option(help="Passes over the outcomes.", min=1)] = 16,
    start: Annotated[
        Path | None,
        typer.Option(help="Begin with these weights, and learn from tilted approaches."),
    ] = None,
) -> None:
    """Fit the network that estimates how likely a grasp holds to the outcomes in a folder."""
    from lab import grasps

    grasps.fit_hold_network(folder, out, rounds=rounds, say=Terminal(stderr=True).say, start=start)
    typer.echo(str(out))


@app.command()
def probability(
    folder: OutcomesFolder,
    weights: Annotated[
        Path | None, typer.Option(help="A file of `grasp fit`; default: shipped weights.")
    ] = None,
    tilted: Annotated[
        bool, typer.Option("--tilted", help="By the outcomes of `--kinds heldout_tilted`.")
    ] = False,
) -> None:
    """Evaluate that network on the outcomes of held-out objects (`--kinds heldout`, or tilted)."""
    from lab import grasps
    from perception import load_hold, shipped_hold

    gripper = grasps.ROBOT.gripper
    hold = load_hold(weights, gripper) if weights else shipped_hold(gripper, tilted=tilted)
    assert hold is not None, "the shipped weights are fitted to this hand"
    judged = grasps.read_outcomes(folder, "heldout_tilted" if tilted else "heldout")
    Terminal().print(grasps.probability_table(judged, hold))


@app.command()
def show(
    image: Annotated[
        Path,
        typer.Argument(
            help="Depth as .png, .tiff, .npy (integer mm or float m), a cloud (.ply, .pcd), a "
            "recording (.rrd), or a ROS bag (.mcap, .db3, .bag)."
        ),
    ],
    out: Annotated[
        Path | None, typer.Option(help="The picture to write; default: next to the image.")
    ] = None,
    focal: Annotated[
        float | None, typer.Option(help="Focal length [px]; default: that of a D435.", min=1.0)
    ] = None,
    camera: Annotated[
        Path | None, typer.Option(help="The camera's model: a ROS CameraInfo, or fx, fy, cx, cy.")
    ] = None,
    scale: Annotated[
        float | None,
        typer.Option(help="Metres per unit; default: 0.001 for whole numbers, else 1.", min=1e-9),
    ] = None,
    at: Annotated[
        float | None, typer.Option(help="Time in a recording [s]; default: the last image.")
    ] = None,
    weights: Annotated[Path | None, typer.Option(help="A weights file.")] = None,
) -> None:
    """Find grasps in a depth image of your camera and draw them over it."""
    from lab import grasps
    from perception import GraspDetector

    summary = grasps.show_grasps(
        image,
        grasps.load_depth_file(image, scale=scale, focal=focal, camera=camera, at=at),
        out or image.with_name(f"{image.stem}_grasps.png"),
        GraspDetector.shipped(grasps.ROBOT.gripper, weights),
    )
    typer.echo(summary)
