"""`frankie-task grasp`: train the grasp networks, judge them, look at what they see."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from app.commands.refuse import refuse

app = typer.Typer(no_args_is_help=True, help="The grasp networks: train, judge, look.")


@app.command()
def train(
    recipe: Annotated[str, typer.Argument(help="`bins`, `ggcnn`, or a recipe file.")] = "bins",
    folder: Annotated[
        Path, typer.Option(help="For images, checkpoints and weights; goes on if there are some.")
    ] = Path("training"),
    workers: Annotated[
        int | None, typer.Option(help="Processes that render; all cores if not given.", min=1)
    ] = None,
    device: Annotated[str, typer.Option(help="auto, cpu or cuda.")] = "auto",
) -> None:
    """Render scenes, label every grasp in them, and teach a network from nothing."""
    from app.lab.grasps.recipe import read_recipe
    from app.lab.grasps.train import make_weights

    console = Console(stderr=True)
    out = make_weights(
        read_recipe(recipe),
        folder,
        workers=workers or os.cpu_count() or 1,
        device=device,
        console=console,
    )
    typer.echo(str(out))


@app.command("eval")
def evaluate(
    weights: Annotated[
        Path | None, typer.Option(help="A file of weights; those that are shipped if not given.")
    ] = None,
    network: Annotated[
        str | None, typer.Option(help="Which shipped network: bins (the default) or ggcnn.")
    ] = None,
    images: Annotated[
        int, typer.Option(help="To judge; half single objects, half clutter.", min=2)
    ] = 1000,
    objects: Annotated[int, typer.Option(help="To pick in the closed loop.", min=0)] = 304,
    cornell: Annotated[
        Path | None, typer.Option(help="Folder of a data set in the Cornell format.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(help="Processes; all cores if not given.", min=1)
    ] = None,
    json: Annotated[Path | None, typer.Option(help="Write all figures here.")] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Draw images whose best grasp fails here (.png).")
    ] = None,
) -> None:
    """Judge grasps on kinds of object that were never learnt from, and say how sure that is."""
    import json as json_format

    from app.lab.grasps.evaluate import Proposing, draw_failures, table
    from app.lab.grasps.evaluate import evaluate as measure

    if weights is not None and network is not None:
        refuse("--network: the file of --weights tells the network already; give one of both")
    for file in (json, plot):
        if file is not None and not file.parent.is_dir():
            refuse(f"{file}: there is no folder {file.parent}; make it first")
    proposing = Proposing(weights=weights, network=network)
    evaluation = measure(
        proposing,
        images=images,
        objects=objects,
        cornell=cornell,
        workers=workers or os.cpu_count() or 1,
    )
    Console().print(table(evaluation))
    typer.echo(f"perception step: {evaluation.step_median_ms:.1f} ms of one core (median)")
    if json is not None:
        json.write_text(json_format.dumps(evaluation.to_json(), indent=1), encoding="utf-8")
    if plot is not None:
        typer.echo(f"{draw_failures(proposing, evaluation, plot)} failures drawn in {plot}")


@app.command()
def show(
    image: Annotated[
        Path,
        typer.Argument(
            help="Depth as .npy, .png, .tiff (whole mm, or metres if float), or an .rrd."
        ),
    ],
    out: Annotated[
        Path | None, typer.Option(help="Where the picture goes; beside the image if not given.")
    ] = None,
    focal: Annotated[
        float | None, typer.Option(help="Focal length [px]; a D435's if not given.", min=1.0)
    ] = None,
    at: Annotated[
        float | None, typer.Option(help="Time in a recording [s]; the last image if not given.")
    ] = None,
    weights: Annotated[Path | None, typer.Option(help="A file of weights.")] = None,
    network: Annotated[str | None, typer.Option(help="Which shipped network.")] = None,
) -> None:
    """Find grasps in a depth image of your own camera, and draw them over it."""
    from app.lab.grasps.show import show_grasps
    from perception import GraspDetector

    told = show_grasps(
        image,
        out or image.with_name(f"{image.stem}_grasps.png"),
        focal=focal,
        at=at,
        detector=GraspDetector(weights, network),
    )
    typer.echo(told)
