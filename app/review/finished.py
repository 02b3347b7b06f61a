"""The recorded runs: find one by name, read it, list all."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.table import Table

from app.core import RECORDING, SUMMARY
from config import UserError

RUNS = Path("runs")
"""Where `frankie-task run` keeps them by default."""
LAST = "last"
"""Name of the newest run."""
UNFINISHED = "unfinished"
"""Outcome of a run without a summary: it is still going on, or its process was killed."""

_STAMP = len("2026-01-31-235959")


class UnknownRunError(UserError):
    """There is no such run; the text says where it was looked for."""


@dataclass(frozen=True, kw_only=True)
class RunRecord:
    """One run, as read from its folder."""

    folder: Path
    summary: Mapping[str, Any]
    """Empty if the run left none."""

    @property
    def began(self) -> str:
        """Start of the run, from the folder's name."""
        return self.folder.name[:_STAMP]

    @property
    def task(self) -> str:
        """Name of the task."""
        return str(self.summary.get("task") or self.folder.name[_STAMP + 1 :])

    @property
    def outcome(self) -> str:
        """One of the values of `End`, or `UNFINISHED`."""
        return str(self.summary.get("outcome", UNFINISHED))

    def row(self) -> dict[str, Any]:
        """Its entry in the list of runs."""
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
        UnknownRunError: there is no such run.
    """
    if name == LAST:
        folders = run_folders(runs)
        if not folders:
            raise UnknownRunError(f"{runs}: no runs here; choose another folder with --runs")
        return folders[-1]
    for path in (Path(name), runs / name):
        folder = path.parent if path.is_file() else path
        if _is_run(folder):
            return folder
    raise UnknownRunError(
        f"{name}: no such run; use its folder, a file in it, its name in {runs}/, or `{LAST}`"
    )


def run_folders(runs: Path) -> list[Path]:
    """The folders of all runs, oldest first."""
    if not runs.is_dir():
        return []
    return sorted((path for path in runs.iterdir() if _is_run(path)), key=_age)


def read_run(folder: Path) -> RunRecord:
    """The run in a folder; the summary is empty if it is missing or damaged."""
    try:
        summary = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        summary = {}
    return RunRecord(folder=folder, summary=summary if isinstance(summary, dict) else {})


def runs_table(records: list[RunRecord]) -> Table:
    """A table with one row per run."""
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
    """Sort key: the second in the folder's name, then when its task file was written."""
    return folder.name[:_STAMP], (folder / "task.yaml").stat().st_mtime
