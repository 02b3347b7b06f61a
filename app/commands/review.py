"""`frankie-task runs`, `view`, `film`, `explain`, `replay`, `delays` and `demo-page`."""

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
_WIDE = 1000
"""Width of the table, so that names are not broken [characters]."""
Runs = Annotated[Path, typer.Option("--runs", help="Where the runs are.")]


def runs(
    runs: Annotated[Path | None, typer.Argument(help="Where the runs are.")] = None,
    where: Runs = Path("runs"),
    as_json: Annotated[bool, typer.Option("--json", help="Print them as JSON.")] = False,
) -> None:
    """List the recorded runs, by the names that the other commands take."""
    from app.review import read_run, run_folders, runs_table

    folder = runs or where
    records = [read_run(path) for path in run_folders(folder)]
    if as_json:
        print(json.dumps([record.row() for record in records], indent=2))
    elif records:
        Terminal(width=_WIDE).print(runs_table(records))
        for record in records:
            if record.damage:
                Terminal(stderr=True).say(f"{record.folder}: {record.damage}")
    else:
        refuse(f"{folder}: no runs here")


def view(
    run: Run = "last",
    runs: Runs = Path("runs"),
    web: Annotated[bool, typer.Option("--web", help="In the browser.")] = False,
    at: Annotated[float | None, typer.Option(help="The moment to show first [s].", min=0.0)] = None,
) -> None:
    """Open the recording of a run in the Rerun viewer."""
    from app.core import RECORDING
    from app.live import open_in_viewer
    from app.review import find_run, recorded_time

    path = Path(run)
    recording = path if path.suffix == ".rrd" else find_run(run, runs) / RECORDING
    at = None if at is None else recorded_time(recording.parent, at)
    raise typer.Exit(
        open_in_viewer(recording, web=web, say=lambda text: typer.echo(text, err=True), at=at)
    )


def demo_page(
    folder: Annotated[Path, typer.Argument(help="Where to make the page.")],
    run: Annotated[str, typer.Option("--run", help="Folder of a run, or its name.")] = "last",
    runs: Runs = Path("runs"),
) -> None:
    """Make a static page that shows a recording in any browser, viewer included."""
    from app.review import demo_page as make
    from app.review import find_run

    page = make(find_run(run, runs), folder)
    say = Terminal().say
    say(f"{page}: copy the folder to any web server, or look at it here:")
    say(f"  python3 -m http.server --directory {folder} --bind 127.0.0.1")


def film(
    run: Annotated[str, typer.Argument(help="Folder of a run, a file in it, or `last`.")],
    out: Annotated[Path, typer.Argument(help="The film: a .webp or .gif file.")],
    runs: Runs = Path("runs"),
    begin: Annotated[float, typer.Option("--from", help="First moment [s].", min=0.0)] = 0.0,
    end: Annotated[float, typer.Option("--to", help="Last moment [s].", min=0.0)] = 20.0,
    speed: Annotated[float, typer.Option(help="Recorded seconds a second.", min=0.1)] = 2.5,
    width: Annotated[int, typer.Option(help="Of the film [px].", min=64, max=1280)] = 960,
) -> None:
    """Make a moving picture of a recorded run; needs a Vulkan driver, but no screen."""
    from app.core import RECORDING
    from app.review import find_run, make_film, recorded_time

    path = Path(run)
    recording = path if path.suffix == ".rrd" else find_run(run, runs) / RECORDING
    begin, end = (recorded_time(recording.parent, moment) for moment in (begin, end))
    pictures = make_film(recording, out, begin=begin, end=end, speed=speed, width=width)
    size = out.stat().st_size / 1e6
    Terminal().say(f"{out}: {pictures} pictures, {size:.1f} MB")


def explain(
    run: Run = "last",
    runs: Runs = Path("runs"),
    html: Annotated[
        Path | None, typer.Option(help="Write a page to share instead: one file, with pictures.")
    ] = None,
    time: Annotated[
        bool, typer.Option("--time", help="Where the time went instead, and what limited it.")
    ] = False,
) -> None:
    """Explain how a run ended: what went wrong first, the attempts, and what took the time."""
    from app.review import explain as explained
    from app.review import find_run, time_use, write_report

    folder = find_run(run, runs)
    if time:
        Terminal().say(str(time_use(folder)))
    elif html is None:
        Terminal().say(str(explained(folder)))
    else:
        write_report(folder, html)
        Terminal().say(f"{html}: open it in a browser, or send it to somebody")


def replay(run: Run = "last", runs: Runs = Path("runs")) -> None:
    """Run what was recorded through tree and controller again, and compare the commands.

    Of a task that looks at images, only after `run --replayable`, which keeps them.
    """
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
