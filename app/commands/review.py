"""`frankie-task runs`, `view`, `explain` and `replay`."""

from pathlib import Path
from typing import Annotated

import typer

from app.commands.refuse import refuse
from app.terminal import Terminal

Run = Annotated[
    str, typer.Argument(help="Folder of a run, a file in it, its name in --runs, or `last`.")
]
_WIDE = 1000  # width of the table, so that names are not broken [characters]
Runs = Annotated[Path, typer.Option("--runs", help="Where the runs are.")]


def runs(
    folder: Annotated[Path, typer.Argument(help="Where the runs are.")] = Path("runs"),
) -> None:
    """List the recorded runs, by the names that the other commands take."""
    from app.review import read_run, run_folders, runs_table

    records = [read_run(path) for path in run_folders(folder)]
    if not records:
        refuse(f"{folder}: no runs here")
    Terminal(width=_WIDE).print(runs_table(records))
    for record in records:
        if record.damage:
            Terminal(stderr=True).say(f"{record.folder}: {record.damage}")


def view(
    run: Run = "last",
    runs: Runs = Path("runs"),
    web: Annotated[bool, typer.Option("--web", help="In the browser.")] = False,
) -> None:
    """Open the recording of a run, or an MCAP file, in the Rerun viewer."""
    from app.live import open_in_viewer

    open_in_viewer(recording_of(run, runs), web=web, say=lambda text: typer.echo(text, err=True))


def recording_of(run: str, runs: Path) -> Path:
    """The recording of a run, as the commands name it."""
    from app.core import RECORDING
    from app.review import find_run

    if run.endswith((".rrd", ".mcap")):
        return Path(run)
    return said_losses(find_run(run, runs)) / RECORDING


def said_losses(folder: Path) -> Path:
    """The folder of a run, after a line for each of its files that is cut."""
    from app.core import losses

    for lost in losses(folder):
        Terminal(stderr=True).say(lost)
    return folder


def explain(run: Run = "last", runs: Runs = Path("runs")) -> None:
    """Explain how a run ended: what went wrong first, the attempts, and what took the time."""
    from app.review import explain as explained
    from app.review import find_run

    folder = find_run(run, runs)
    explanation = explained(folder)
    said_losses(folder)
    Terminal().say(str(explanation))


def replay(run: Run = "last", runs: Runs = Path("runs")) -> None:
    """Run what was recorded through tree and controller again, and compare the commands.

    Of a run that looked at images, as it does by default to be registered to the map, only after
    `run --replayable`, which keeps them.
    """
    from app.core import replay_run
    from app.review import find_run

    folder = find_run(run, runs)
    result = replay_run(folder)
    said_losses(folder)
    Terminal().say(str(result))
    raise typer.Exit(0 if result.identical else 1)
