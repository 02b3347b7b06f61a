"""The commands of the laboratory: `frankie-task bench`, `grasp` and `calibrate`."""

import typer

from lab.bench import app as bench
from lab.commands.calibrate import app as calibrate
from lab.commands.grasp import app as grasp


def add_to(command_line: typer.Typer) -> None:
    """Add the commands of the laboratory to the product's command line."""
    for name, group in (("bench", bench), ("grasp", grasp), ("calibrate", calibrate)):
        command_line.add_typer(group, name=name)
