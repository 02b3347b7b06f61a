"""The runs that were recorded: find one by what a person calls it, read it, list them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.table import Table

from app.core.folder import RECORDING, SUMMARY
from config import UserError

RUNS = Path("runs")
"""Where `frankie-task run` keeps them unless told otherwise."""
LAST = "last"
"""Stands for the newest run."""
UNFINISHED = "unfinished"
"""What a run came to that left no summary: it goes on, or its process was killed."""

_STAMP = len("2026-01-31-235959")


class UnknownRunError(UserError):
    """There is no such run; the text says where was looked."""


@dataclass(frozen=True, kw_only=True)
class RunRecord:
    """One run, as its folder tells."""

    folder: Path
    summary: Mapping[str, Any]
    """Empty if the run left none."""

    @property
    def began(self) -> str:
        """When, as the folder's name says."""
        return self.folder.name[:_STAMP]

    @property
    def task(self) -> str:
        """Name of the task."""
        return str(self.summary.get("task") or self.folder.name[_STAMP + 1 :])

    @property
    def outcome(self) -> str:
        """One of the values of `End`, or unfinished."""
        return str(self.summary.get("outcome", UNFINISHED))

    def row(self) -> dict[str, Any]:
        """What the list tells about it."""
        s = self.summary
        return {
            "run": self.folder.name,
            "began": self.began,
            "task": self.task,
            "outcome": self.outcome,
            "node": s.get("node", ""),
            "duration_s": s.get("duration_s"),
            "placed": s.get("placed"),
            "objects": s.get("objects"),
        }


def find_run(name: str, runs: Path = RUNS) -> Path:
    """The folder of a run.

    Args:
        name: a folder, a file in it, the name of a folder in `runs`, or `last`.
        runs: where the runs are.

    Raises:
        UnknownRunError: it is none of these.
    """
    if name == LAST:
        folders = run_folders(runs)
        if not folders:
            raise UnknownRunError(f"{runs}: no runs here; say where with --runs")
        return folders[-1]
    for path in (Path(name), runs / name):
        folder = path.parent if path.is_file() else path
        if _is_run(folder):
            return folder
    raise UnknownRunError(
        f"{name}: no run; give its folder, a file in it, a name in {runs}/, or `{LAST}`"
    )


def run_folders(runs: Path) -> list[Path]:
    """The folders of all runs, oldest first."""
    if not runs.is_dir():
        return []
    return sorted((path for path in runs.iterdir() if _is_run(path)), key=_age)


def read_run(folder: Path) -> RunRecord:
    """What a folder tells; without a sound summary that is little."""
    try:
        summary = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        summary = {}
    return RunRecord(folder=folder, summary=summary if isinstance(summary, dict) else {})


def runs_table(records: list[RunRecord]) -> Table:
    """One row a run."""
    table = Table(box=None, pad_edge=False)
    table.add_column("began")
    table.add_column("task")
    table.add_column("outcome")
    for column in ("duration [s]", "placed"):
        table.add_column(column, justify="right")
    table.add_column("failed in")
    for row in (record.row() for record in records):
        duration = row["duration_s"]
        known = row["placed"] is not None
        table.add_row(
            row["began"],
            row["task"],
            row["outcome"],
            f"{duration:.1f}" if duration is not None else "-",
            f"{row['placed']} of {row['objects']}" if known else "-",
            row["node"],
        )
    return table


def _is_run(folder: Path) -> bool:
    return (folder / RECORDING).is_file() or (folder / "task.yaml").is_file()


def _age(folder: Path) -> tuple[str, float]:
    """Sorts by the second in the name, and within a second by when the folder was made."""
    return folder.name[:_STAMP], (folder / "task.yaml").stat().st_mtime
