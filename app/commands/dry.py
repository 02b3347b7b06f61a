"""`frankie-task dry`: a task without a robot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.commands.refuse import find_tree, task_parameters
from app.terminal import Terminal, visible

if TYPE_CHECKING:
    from app.core import Saved


def dry(
    tree: Annotated[str, typer.Argument(help="A task file, or the name of a shipped task.")],
    outcome: Annotated[
        list[str] | None,
        typer.Option(help="What a leaf answers in turn, as grasp=failure,failure,success."),
    ] = None,
    key: Annotated[
        list[str] | None, typer.Option(help="What leaves write to a key, as found=3.")
    ] = None,
    parameter: Annotated[
        list[str] | None, typer.Option("--parameter", "-p", help="A task parameter, key=value.")
    ] = None,
    places: Annotated[Path | None, typer.Option(help="Poses and regions of a site.")] = None,
    ticks: Annotated[int, typer.Option(help="At most; there are ten in a second.", min=1)] = 1000,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print all steps as one JSON object.")
    ] = False,
    watch: Annotated[
        bool, typer.Option("--watch", help="Do it anew whenever the task is saved.")
    ] = False,
) -> None:
    """Try the logic of a task without a robot: leaves end at once, as you say."""
    from app.authoring import dry_run
    from app.core import again_on_save

    path, parameters = find_tree(tree), task_parameters(parameter or [])
    codes: list[int] = []

    def act(saved: Saved | None = None) -> bool:
        result = dry_run(
            path,
            outcomes=outcome or [],
            keys=key or [],
            overrides=parameters,
            places=places,
            most_ticks=ticks,
        )
        typer.echo(result.to_json() if as_json else visible(result.to_text()))
        codes.append(result.outcome.end.exit_code)
        return False

    if watch:
        again_on_save(path, parameters, places, act=act, say=Terminal(stderr=True).say)
    else:
        act()
    raise typer.Exit(codes[-1] if codes else 2)
