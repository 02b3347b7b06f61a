"""The command line. Heavy imports happen where they are used, so that `--help` is quick."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from app.afterwards import explain, export, runs, view
from app.bench.commands import bench
from app.outcome import EXIT_BAD_INPUT
from app.refuse import bad_input, find_tree, refuse

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    help="Taskable reactive mobile manipulation: a behaviour tree in YAML, a robot that does it.",
)

app.add_typer(bench, name="bench")
grasp = typer.Typer(no_args_is_help=True, help="The grasp network: train it, see how good it is.")
app.add_typer(grasp, name="grasp")


class RobotChoice(StrEnum):
    """The robots that can run a task."""

    SIM = "sim"
    OMNI = "omni"


class Speed(StrEnum):
    """How fast simulated time goes."""

    REAL = "real"
    MAX = "max"


class ViewChoice(StrEnum):
    """How a run is watched."""

    AUTO = "auto"
    SPAWN = "spawn"
    WEB = "web"
    NONE = "none"


def _parameters(values: list[str]) -> dict[str, str]:
    parameters = {}
    for value in values:
        key, equals, text = value.partition("=")
        if not equals or not key:
            refuse(f"-p {value}: a parameter is given as key=value, for example -p attempts=3")
        parameters[key] = text
    return parameters


@app.command()
def run(
    tree: Annotated[str, typer.Argument(help="A task file, or the name of a shipped task.")],
    robot: Annotated[RobotChoice, typer.Option(help="Who does it.")] = RobotChoice.SIM,
    scene: Annotated[str, typer.Option(help="A shipped scene or a scene file.")] = "household",
    seed: Annotated[int, typer.Option(help="Of objects and camera noise.", min=0)] = 0,
    parameter: Annotated[
        list[str] | None, typer.Option("--parameter", "-p", help="A task parameter, key=value.")
    ] = None,
    speed: Annotated[Speed, typer.Option(help="Pace of simulated time.")] = Speed.MAX,
    record: Annotated[Path, typer.Option(help="Folder for the folders of runs.")] = Path("runs"),
    weights: Annotated[Path | None, typer.Option(help="Of the grasp network.")] = None,
    view: Annotated[
        ViewChoice,
        typer.Option(
            help="Watch in a window, in a browser, or not; auto: a window if there is a screen."
        ),
    ] = ViewChoice.AUTO,
    view_host: Annotated[
        str, typer.Option(help="Address to serve viewers on; there is no password.")
    ] = "127.0.0.1",
    view_port: Annotated[
        int | None, typer.Option(help="Of the live data.", min=1, max=65535)
    ] = None,
    web_port: Annotated[
        int | None, typer.Option(help="Of the page of --view web.", min=1, max=65535)
    ] = None,
    control: Annotated[
        bool, typer.Option("--control", help="Serve a page that pauses, steps and stops the run.")
    ] = False,
    control_port: Annotated[
        int | None, typer.Option(help="Of the page of --control.", min=1, max=65535)
    ] = None,
    paused: Annotated[bool, typer.Option("--paused", help="Wait before the first tick.")] = False,
    stop_before: Annotated[
        list[str] | None,
        typer.Option("--break", help="Pause before this node: its name, key or path."),
    ] = None,
    groot2: Annotated[
        bool, typer.Option("--groot2", help="Serve Groot2, the tree editor.")
    ] = False,
    groot2_port: Annotated[
        int, typer.Option(help="Of --groot2; the next one is taken too.", min=1, max=65534)
    ] = 1667,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the summary as one JSON object.")
    ] = False,
) -> None:
    """Run a task; leaves a folder with a recording and a summary."""
    from app.control_room import ControlOptions
    from app.monitor import View, ViewOptions
    from app.run import RunOptions, run_task

    with bad_input():
        result = run_task(
            RunOptions(
                tree=find_tree(tree),
                robot=robot.value,
                scene=scene,
                seed=seed,
                parameters=_parameters(parameter or []),
                paced=speed is Speed.REAL,
                record=record,
                weights=weights,
                view=ViewOptions(
                    view=View(view.value), host=view_host, port=view_port, web_port=web_port
                ),
                control=ControlOptions(
                    page=control,
                    page_port=control_port,
                    paused=paused,
                    breaks=tuple(stop_before or ()),
                    groot=groot2,
                    groot_port=groot2_port,
                ),
            )
        )
    for_people = Console(stderr=as_json)
    if as_json:
        print(result.summary.to_json())
    result.summary.show(for_people)
    for_people.print(f"left in {result.folder}/", highlight=False)
    if result.warning:
        Console(stderr=True).print(result.warning, soft_wrap=True, markup=False)
    raise typer.Exit(result.outcome.end.exit_code)


@app.command()
def check(
    trees: Annotated[list[str], typer.Argument(help="Task files, or names of shipped tasks.")],
) -> None:
    """Name every mistake in task files; ends with exit code 2 if there is one."""
    from trees.language import LeafError, Severity
    from trees.language import check as mistakes_in

    console = Console()
    errors = 0
    for tree in trees:
        path = find_tree(tree)
        try:
            mistakes = mistakes_in(path)
        except LeafError as error:
            refuse(str(error))
        for mistake in mistakes:
            console.print(str(mistake), soft_wrap=True, highlight=False, markup=False)
        bad = sum(mistake.severity is Severity.ERROR for mistake in mistakes)
        errors += bad
        if not bad:
            console.print(f"{path}: good", highlight=False, markup=False)
    if errors:
        raise typer.Exit(EXIT_BAD_INPUT)


for command in (runs, view, explain, export):
    app.command()(command)


@grasp.command("train")
def grasp_train(
    out: Annotated[Path, typer.Argument(help="Where the weights go (.safetensors).")],
    images: Annotated[int, typer.Option(help="Rendered images to learn from.", min=8)] = 4200,
    steps: Annotated[int | None, typer.Option(help="How long to train; repeatable.")] = None,
    minutes: Annotated[float, typer.Option(help="How long to train without --steps.")] = 30.0,
    seed: Annotated[int, typer.Option(help="Of scenes, noise and training.", min=0)] = 0,
    samples: Annotated[
        Path | None, typer.Option(help="Rendered images (.npz): read if there, else kept.")
    ] = None,
) -> None:
    """Render scenes, label grasps in them, and train GG-CNN from nothing."""
    from app.grasps.train import make_weights

    if not out.parent.is_dir():
        refuse(f"{out}: there is no folder {out.parent}; make it first")
    make_weights(
        out,
        images=images,
        seed=seed,
        steps=steps,
        minutes=minutes,
        samples_file=samples,
        say=lambda text: typer.echo(text, err=True),
    )


@grasp.command("eval")
def grasp_eval(
    scene: Annotated[str, typer.Option(help="A shipped scene or a scene file.")] = "household",
    scenes: Annotated[int, typer.Option(help="How many seeds of it.", min=1)] = 20,
    weights: Annotated[Path | None, typer.Option(help="Default: those that are shipped.")] = None,
) -> None:
    """Empty containers that were never trained on; count the grasps that hold."""
    from app.grasps.evaluate import FIRST_SEED, evaluate
    from perception import GraspDetector

    with bad_input():
        ends = evaluate(GraspDetector(weights), scene, range(FIRST_SEED, FIRST_SEED + scenes))
    attempts = ends.total()
    typer.echo(f"{scene}, {scenes} seeds: {ends['held']} of {attempts} grasps held")
    for end, count in ends.most_common():
        typer.echo(f"{count:5d}  {100.0 * count / max(attempts, 1):5.1f} %  {end}")


def main() -> None:
    """Entry point of `frankie-task`."""
    app()


if __name__ == "__main__":
    main()
