"""Shared options of the benches, and output of their results."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.commands import refuse
from app.terminal import Terminal

if TYPE_CHECKING:
    from app.core import Summary

BOTH = "both"  # value of `--robot` for all shipped robots

_WIDTH = 120  # of a table outside of a terminal [characters]

Robot = Annotated[str, typer.Option(help="`frankie`, `omni`, `both`, or a robot file.")]
OneRobot = Annotated[str, typer.Option(help="`frankie`, `omni`, or a robot file.")]
World = Annotated[str, typer.Option(help="`kinematic` or `physics`.")]
Seeds = Annotated[str, typer.Option(help="First and last seed; a run for each.", metavar="A-B")]
Record = Annotated[Path, typer.Option(help="Folder for the folders of runs.")]
Json = Annotated[Path | None, typer.Option("--json", help="Also write the figures to this file.")]
Workers = Annotated[int | None, typer.Option(help="Processes; default: one per core.", min=1)]
Cluster = Annotated[
    str | None,
    typer.Option(help="Address of a dask.distributed scheduler; instead of processes here."),
]
Period = Annotated[float, typer.Option(help="Control period in seconds.", min=0.001, max=0.1)]
ReverseSpeed = Annotated[
    float | None,
    typer.Option(
        help="Limit of the base backwards in m/s; default: its share in the robot's description.",
        min=0.01,
    ),
]


def chosen_robots(robot: str) -> list[str]:
    """The robots that `--robot` selects."""
    return ["frankie", "omni"] if robot == BOTH else [robot]


def chosen(option: str, wanted: Sequence[str] | None, valid: Sequence[str]) -> list[str]:
    """The values of a repeatable option, in the order of the valid ones; None is all of them."""
    from config import suggest

    for name in wanted or ():
        if name not in valid:
            refuse(f"{option} {name}: there is none of this name; {suggest(name, valid)}")
    return [name for name in valid if wanted is None or name in wanted]


def show(*lines: Any) -> None:
    """Print tables and lines on standard output, wide enough even if it is not a terminal."""
    terminal = Terminal()
    terminal = terminal if terminal.is_terminal else Terminal(width=_WIDTH)
    for line in lines:
        terminal.print(line, highlight=False, markup=False, soft_wrap=isinstance(line, str))


def announcing(number: int) -> Callable[[Summary], None]:
    """A function that prints the summary of each of a number of runs, and how many are done."""
    ended = 0

    def done(summary: Summary) -> None:
        nonlocal ended
        ended += 1
        terminal = Terminal(stderr=True)
        summary.show(terminal)
        terminal.say(f"{ended} of {number} runs done")

    return done


def check_writable(path: Path | None) -> None:
    """Refuse a file that cannot be written, before anything is measured."""
    if path is None:
        return
    try:
        path.open("a", encoding="utf-8").close()
    except OSError as error:
        refuse(f"--json {path}: cannot be written ({error.strerror})")


def write_json(path: Path | None, content: dict[str, Any]) -> None:
    """Write an object and the machine to the file of `--json`, if it was given."""
    from lab.shared import machine

    if path is not None:
        path.write_text(json.dumps(machine() | content, indent=2) + "\n", encoding="utf-8")


def write_results(path: Path | None, results: Sequence[Any], **about: Any) -> None:
    """Write dataclasses as `results` of the JSON object."""
    write_json(path, {**about, "results": [asdict(one) for one in results]})


def seed_range(seeds: str) -> range:
    """The seeds that `--seeds A-B` names."""
    first, dash, last = seeds.partition("-")
    if not (first.isdigit() and (last.isdigit() or not dash)):
        refuse(f"--seeds {seeds}: give the first and the last seed, for example 0-4")
    return range(int(first), int(last or first) + 1)
