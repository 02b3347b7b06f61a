"""The command line. Heavy imports happen where they are used, so that `--help` is quick."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from app.afterwards import explain, runs, view
from app.authoring import authoring
from app.bench.commands import bench
from app.outcome import EXIT_BAD_INPUT
from app.refuse import bad_input, find_tree, refuse
from app.run_command import run

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    help="Taskable reactive mobile manipulation: a behaviour tree in YAML, a robot that does it.",
)

app.add_typer(authoring)
for command in (run, runs, view, explain):
    app.command()(command)
app.add_typer(bench, name="bench")
grasp = typer.Typer(no_args_is_help=True, help="The grasp network: train it, see how good it is.")
app.add_typer(grasp, name="grasp")


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
            console.print(f"{path}: good", soft_wrap=True, highlight=False, markup=False)
    if errors:
        raise typer.Exit(EXIT_BAD_INPUT)


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
