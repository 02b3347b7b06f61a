"""The command line. Heavy imports happen where they are used, so that `--help` is quick."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from app.bench.commands import bench
from app.grasps.commands import app as grasp
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
app.add_typer(grasp, name="grasp")


class RobotChoice(StrEnum):
    """The robots that can run a task."""

    SIM = "sim"
    OMNI = "omni"


class Speed(StrEnum):
    """How fast simulated time goes."""

    REAL = "real"
    MAX = "max"


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
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the summary as one JSON object.")
    ] = False,
) -> None:
    """Run a task; leaves a folder with a recording and a summary."""
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


def main() -> None:
    """Entry point of `frankie-task`."""
    app()


if __name__ == "__main__":
    main()
