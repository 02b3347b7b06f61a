"""`frankie-task runs`, `view`, `explain`, `replay` and `delays`: about finished runs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from app.commands.refuse import refuse
from app.terminal import Terminal

Run = Annotated[
    str, typer.Argument(help="Folder of a run, a file in it, its name in --runs, or `last`.")
]
Runs = Annotated[Path, typer.Option("--runs", help="Where the runs are.")]


def runs(
    folder: Annotated[Path, typer.Argument(help="Where the runs are.")] = Path("runs"),
    as_json: Annotated[bool, typer.Option("--json", help="Print them as JSON.")] = False,
) -> None:
    """List the recorded runs: start, task and outcome."""
    from app.review import read_run, run_folders, runs_table

    records = [read_run(path) for path in run_folders(folder)]
    if as_json:
        print(json.dumps([record.row() for record in records], indent=2))
    elif records:
        Terminal().print(runs_table(records))
        for record in records:
            if record.damage:
                Terminal(stderr=True).say(f"{record.folder}: {record.damage}")
    else:
        refuse(f"{folder}: no runs here")


def view(
    run: Run = "last",
    runs: Runs = Path("runs"),
    web: Annotated[bool, typer.Option("--web", help="In the browser.")] = False,
) -> None:
    """Open the recording of a run in the Rerun viewer."""
    from app.core import RECORDING
    from app.live import open_in_viewer
    from app.review import find_run

    path = Path(run)
    recording = path if path.suffix == ".rrd" else find_run(run, runs) / RECORDING
    open_in_viewer(recording, web=web, say=lambda text: typer.echo(text, err=True))


def explain(run: Run = "last", runs: Runs = Path("runs")) -> None:
    """Explain how a run ended: the node, the time, the reason and the key figures."""
    from app.review import explain as explained
    from app.review import find_run

    text = str(explained(find_run(run, runs)))
    Terminal().say(text)


def replay(run: Run = "last", runs: Runs = Path("runs")) -> None:
    """Run what was recorded through tree and controller again, and compare the commands."""
    from app.core import replay_run
    from app.review import find_run

    result = replay_run(find_run(run, runs))
    Terminal().say(str(result))
    raise typer.Exit(0 if result.identical else 1)


def delays(run: Run = "last", runs: Runs = Path("runs")) -> None:
    """Measure how late a robot followed its commands in a run."""
    import numpy as np

    from app.review import delays as measured
    from app.review import find_run

    console, found = Terminal(), measured(find_run(run, runs))
    for one in found:
        console.say(str(one))
    for key, part in (("base_lag", "base"), ("arm_lag", "joint")):
        if totals := [one.total for one in found if one.axis.startswith(part)]:
            console.say(f"{key}: {np.median(totals):.2f}")
