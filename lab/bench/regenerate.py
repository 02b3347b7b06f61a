"""Every figure of a list of experiments once more, beside what it was."""

from __future__ import annotations

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

from config import StrictModel, UserError


class RegenerateError(UserError):
    """An experiment did not run, or has no such figure."""


class Experiment(StrictModel):
    """One command of `frankie-task bench`, and the figures that are read off its JSON."""

    table: str
    """Which table of the page it is."""
    command: str
    """What follows `frankie-task bench`."""
    quick: str
    """Options that make it small."""
    figures: Annotated[list[tuple[str, str, float, float]], Field(min_length=1)]
    """Name, where it stands in the JSON as `results.0.time_s`, what it was, and how much more or
    less is no change."""


class Experiments(StrictModel):
    """The file of the experiments of a page."""

    experiments: Annotated[list[Experiment], Field(min_length=1)]


@dataclass(frozen=True, kw_only=True)
class Regenerated:
    """A figure, as it was and as it is."""

    table: str
    name: str
    was: float
    within: float
    now: float

    @property
    def changed(self) -> bool:
        """Whether it is further from what it was than counts as none."""
        return abs(self.now - self.was) > self.within + 1e-9


def regenerate(
    experiment: Experiment, folder: Path, quick: bool
) -> tuple[list[Regenerated], float]:
    """Run an experiment, and read its figures.

    Args:
        experiment: what to run.
        folder: where its JSON, what it printed and its runs go.
        quick: in its small size, whose figures are others.

    Returns:
        The figures, and how long it took [s].

    Raises:
        RegenerateError: it failed, or a figure is not there.
    """
    words = shlex.split(experiment.command) + (shlex.split(experiment.quick) if quick else [])
    file = folder / f"{_file_name(experiment.table)}.json"
    command = [sys.executable, "-m", "frankie_task_cli", "bench", *words, "--json", str(file)]
    begun = perf_counter()
    with file.with_suffix(".txt").open("w", encoding="utf-8") as said:
        ran = subprocess.run(command, stdout=said, stderr=subprocess.STDOUT, check=False)
    if ran.returncode:
        failed = f"frankie-task bench {shlex.join(words)}: exit code {ran.returncode}"
        raise RegenerateError(f"{failed}; what it said is in {said.name}")
    report = json.loads(file.read_text(encoding="utf-8"))
    return [
        Regenerated(
            table=experiment.table,
            name=name,
            was=was,
            within=within,
            now=_figure(report, where, experiment.table),
        )
        for name, where, was, within in experiment.figures
    ], perf_counter() - begun


def regenerated_table(figures: Iterable[Regenerated], quick: bool) -> Table:
    """Was and is, figure by figure; of a small size nothing is judged."""
    table = Table(title="Was and is" + (", in small sizes: not to be compared" if quick else ""))
    for column in ("table", "figure", "was", "no change within", "is", ""):
        table.add_column(column, justify="left" if column in ("table", "figure") else "right")
    last = ""
    for one in figures:
        mark = "CHANGED" if one.changed and not quick else ""
        table.add_row(
            one.table if one.table != last else "",
            one.name,
            f"{one.was:g}",
            f"± {one.within:g}",
            f"{one.now:.4g}",
            mark,
        )
        last = one.table
    return table


def _file_name(table: str) -> str:
    return "".join(letter if letter.isalnum() else "_" for letter in table)


def _figure(report: object, where: str, table: str) -> float:
    found = report
    try:
        for step in where.split("."):
            found = found[int(step)] if isinstance(found, list) else found[step]  # type: ignore[index]
        return float(found)  # type: ignore[arg-type]
    except (LookupError, TypeError, ValueError):
        raise RegenerateError(f"{table}: its JSON has no figure at `{where}`") from None
