"""`frankie-task mcap`: a run as messages in a file, for Foxglove and for ROS 2."""

from pathlib import Path
from typing import Annotated, Literal

import typer


def mcap(
    run: Annotated[str, typer.Argument(help="Folder of a run, its name in --runs, or `last`.")],
    output: Annotated[Path, typer.Argument(help="The new file.")],
    schemas: Annotated[
        Literal["ros2", "foxglove"], typer.Option(help="ROS 2 messages, or Foxglove's own schemas.")
    ] = "ros2",
    runs: Annotated[Path, typer.Option("--runs", help="Where the runs are.")] = Path("runs"),
) -> None:
    """Write a run as messages with their definitions, for Foxglove, and for ROS 2."""
    from app.commands import said_losses
    from app.review import find_run
    from extensions.ros2.bag import export_mcap

    folder = find_run(run, runs)
    export_mcap(folder, output, schemas)
    said_losses(folder)
    typer.echo(f"{output}: written")
