"""`frankie-task runs`, `view` and `explain`: what to do with runs that are over."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from app.commands.refuse import refuse

Run = Annotated[
    str, typer.Argument(help="Folder of a run, a file in it, its name in --runs, or `last`.")
]
Runs = Annotated[Path, typer.Option("--runs", help="Where the runs are.")]


def find(run: str, runs: Path) -> Path:
    """The folder of a run; refuses what is none."""
    from app.review.finished import find_run

    return find_run(run, runs)


def runs(
    folder: Annotated[Path, typer.Argument(help="Where the runs are.")] = Path("runs"),
    as_json: Annotated[bool, typer.Option("--json", help="Print them as JSON.")] = False,
) -> None:
    """List the recorded runs: when, what, how it ended."""
    from app.review.finished import read_run, run_folders, runs_table

    records = [read_run(path) for path in run_folders(folder)]
    if as_json:
        print(json.dumps([record.row() for record in records], indent=2))
    elif records:
        Console().print(runs_table(records))
    else:
        refuse(f"{folder}: no runs here")


def view(
    run: Run = "last",
    runs: Runs = Path("runs"),
    web: Annotated[bool, typer.Option("--web", help="In the browser.")] = False,
) -> None:
    """Open the recording of a run in the Rerun viewer."""
    from app.core.folder import RECORDING
    from app.review.open_recording import replay

    path = Path(run)
    recording = path if path.suffix == ".rrd" else find(run, runs) / RECORDING
    replay(recording, web=web, say=lambda text: typer.echo(text, err=True))


def explain(run: Run = "last", runs: Runs = Path("runs")) -> None:
    """Say in words why a run ended as it did: which node, when, and the values that mattered."""
    from app.review.explain import explain as explained

    text = str(explained(find(run, runs)))
    Console().print(text, soft_wrap=True, highlight=False, markup=False)
