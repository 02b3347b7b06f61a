"""Comparison of the documented figures of a list of experiments with new ones."""

import json
import shlex
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Annotated

from pydantic import Field
from rich.table import Table

from config import UserError
from config.reader import StrictModel


class Experiment(StrictModel):
    """One command of `frankie-task bench`, and the figures to read from its JSON."""

    table: str  # Table of the page
    command: str  # arguments of `frankie-task bench`
    quick: str  # options that make it small
    figures: Annotated[list[tuple[str, str, float, float]], Field(min_length=1)]
    """Name, path in the JSON such as `results.0.time_s`, documented value, and tolerance."""


class Experiments(StrictModel):
    """The file of the experiments of a page."""

    experiments: Annotated[list[Experiment], Field(min_length=1)]


@dataclass(frozen=True, kw_only=True)
class Regenerated:
    """The documented and the new value of a figure."""

    table: str
    name: str
    was: float
    within: float
    now: float

    @property
    def changed(self) -> bool:
        """Whether the difference exceeds the tolerance."""
        return abs(self.now - self.was) > self.within + 1e-9


def regenerate(
    experiment: Experiment, folder: Path, quick: bool
) -> tuple[list[Regenerated], float]:
    """Run an experiment; returns its figures and its duration [s].

    Raises UserError: it failed, or a figure is missing.
    """
    words = shlex.split(experiment.command) + (shlex.split(experiment.quick) if quick else [])
    name = "".join(letter if letter.isalnum() else "_" for letter in experiment.table)
    file = folder / f"{name}.json"
    command = [sys.executable, "-m", "frankie_task_cli", "bench", *words, "--json", str(file)]
    begun = perf_counter()
    with file.with_suffix(".txt").open("w", encoding="utf-8") as output:
        ran = subprocess.run(command, stdout=output, stderr=subprocess.STDOUT, check=False)
    if ran.returncode:
        failed = f"frankie-task bench {shlex.join(words)}: exit code {ran.returncode}"
        raise UserError(f"{failed}; its output is in {output.name}")
    report = json.loads(file.read_text(encoding="utf-8"))
    table = experiment.table
    return [
        Regenerated(
            table=table, name=name, was=was, within=within, now=_figure(report, path, table)
        )
        for name, path, was, within in experiment.figures
    ], perf_counter() - begun


def _figure(report: object, path: str, table: str) -> float:
    found = report
    try:
        for step in path.split("."):
            found = found[int(step)] if isinstance(found, list) else found[step]  # type: ignore[index]
        return float(found)  # type: ignore[arg-type]
    except (LookupError, TypeError, ValueError):
        raise UserError(f"{table}: its JSON has no figure at `{path}`") from None


def regenerated_table(figures: Iterable[Regenerated], quick: bool) -> Table:
    """Documented and new values; with a small size nothing is judged."""
    table = Table(title="Was and is" + (", in small sizes: not to be compared" if quick else ""))
    for column in ("table", "figure", "was", "no change within", "is", ""):
        table.add_column(column, justify="left" if column in ("table", "figure") else "right")
    last = ""
    for one in figures:
        mark = "CHANGED" if one.changed and not quick else ""
        name = one.table if one.table != last else ""
        table.add_row(name, one.name, f"{one.was:g}", f"± {one.within:g}", f"{one.now:.4g}", mark)
        last = one.table
    return table
