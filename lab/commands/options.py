"""What the benches share: their options, and where their figures go."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from app.commands import refuse
from app.terminal import Terminal

BOTH = "both"
"""Value of `--robot` for all shipped robots."""

_WIDTH = 120  # of a table outside of a terminal [characters]

Robot = Annotated[str, typer.Option(help="`frankie`, `omni` or `both`.")]
Json = Annotated[Path | None, typer.Option("--json", help="Also write the figures to this file.")]
Workers = Annotated[int | None, typer.Option(help="Processes; default: one per core.", min=1)]
Cluster = Annotated[
    str | None, typer.Option(help="Address of a dask.distributed scheduler to use.")
]
Period = Annotated[float, typer.Option(help="Control period in seconds.", min=0.001, max=0.1)]
BaseSpeed = Annotated[
    float | None,
    typer.Option(help="Limit of the base in m/s; default: the robot's.", min=0.05),
]
ReverseSpeed = Annotated[
    float | None,
    typer.Option(
        help="Limit of the base backwards in m/s; default: its share in the robot's description.",
        min=0.01,
    ),
]


def chosen_robots(robot: str) -> list[str]:
    """The robots that `--robot` selects."""
    from config import suggest
    from robots import robot_names

    names = robot_names()
    if robot == BOTH:
        return names
    if robot not in names:
        refuse(f"--robot {robot}: no such robot; {suggest(robot, [*names, BOTH])}")
    return [robot]


def workers_of(workers: int | None) -> int:
    """The number of processes of `--workers`."""
    return workers or os.cpu_count() or 1


def console() -> Terminal:
    """Standard output, wide enough for a table even if it is not a terminal."""
    console = Terminal()
    return console if console.is_terminal else Terminal(width=_WIDTH)


def check_writable(path: Path | None) -> None:
    """Refuse a file that cannot be written, before anything is measured."""
    if path is None:
        return
    try:
        path.open("a", encoding="utf-8").close()
    except OSError as error:
        refuse(f"--json {path}: cannot be written ({error.strerror})")


def write_json(path: Path | None, text: str) -> None:
    """Write the figures to the file of `--json`, if it was given."""
    if path is not None:
        path.write_text(text + "\n", encoding="utf-8")


def write_results(path: Path | None, results: Sequence[Any], about: Mapping[str, Any]) -> None:
    """Write one JSON object, if a file was given: `about` the run, and `results`, dataclasses."""
    write_json(path, json.dumps({**about, "results": [asdict(one) for one in results]}, indent=2))


def seed_range(seeds: str) -> range:
    """The seeds that `--seeds A-B` names."""
    first, dash, last = seeds.partition("-")
    if not (first.isdigit() and (last.isdigit() or not dash)):
        refuse(f"--seeds {seeds}: give the first and the last seed, for example 0-4")
    return range(int(first), int(last or first) + 1)
