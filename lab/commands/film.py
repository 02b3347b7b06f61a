"""`frankie-task film`."""

from pathlib import Path
from typing import Annotated

import typer

from app.commands import Run, Runs, recording_of
from app.terminal import Terminal


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
    from app.review import recorded_time
    from config import counted
    from lab.film import make_film

    recording = recording_of(run, runs)
    out = out or recording.with_suffix(".webp")
    begin, end = (recorded_time(recording.parent, moment) for moment in (begin, end))
    Terminal().say(f"{out}: {counted(make_film(recording, out, begin, end), 'picture')}")
