"""`frankie-task runs`, `view`, `film`, `explain`, `replay` and `delays`."""

from pathlib import Path
from typing import Annotated

import typer

from app.commands.refuse import refuse, write
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

    open_in_viewer(_recording(run, runs), web=web, say=lambda text: typer.echo(text, err=True))


def _recording(run: str, runs: Path) -> Path:
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


def film(
    run: Run = "last",
    out: Annotated[
        Path | None, typer.Argument(help="The film, a .webp file; by default beside the recording.")
    ] = None,
    runs: Runs = Path("runs"),
    begin: Annotated[float, typer.Option("--from", help="First moment [s].", min=0.0)] = 0.0,
    end: Annotated[float, typer.Option("--to", help="Last moment [s].", min=0.0)] = 20.0,
) -> None:
    """Make a moving picture of a recorded run; needs a Vulkan driver, but no screen."""
    from app.review import make_film, recorded_time
    from config import counted

    recording = _recording(run, runs)
    out = out or recording.with_suffix(".webp")
    begin, end = (recorded_time(recording.parent, moment) for moment in (begin, end))
    Terminal().say(f"{out}: {counted(make_film(recording, out, begin, end), 'picture')}")


def explain(
    run: Run = "last",
    runs: Runs = Path("runs"),
    html: Annotated[Path | None, typer.Option(help="Write a page with a map instead.")] = None,
) -> None:
    """Explain how a run ended: what went wrong first, the attempts, and what took the time."""
    from app.review import explain as explained
    from app.review import explanation_page, find_run

    folder = find_run(run, runs)
    explanation = explained(folder)
    said_losses(folder)
    if html is None:
        Terminal().say(str(explanation))
    else:
        write(html, explanation_page(explanation))
        Terminal().say(f"{html}: written")


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
