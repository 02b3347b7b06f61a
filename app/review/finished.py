"""Recorded runs: find one by name, read it, list all."""

import re
from dataclasses import dataclass
from datetime import UTC, datetime
from os.path import getmtime, isdir, isfile, lexists
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from rich.table import Table

from app.core import COMMANDS, EVENTS, RECORDING, STATES, SUMMARY, whole_rows
from app.review.event_log import DamagedRunError, first_problem
from app.task_time import in_words, task_time
from config import UserError
from config.arrays import Array

RUNS = Path("runs")  # where `frankie-task run` keeps them by default
LAST = "last"
UNFINISHED = "unfinished"
"""Outcome of a run without a summary: it is still going on, or its process was killed."""
DAMAGED = "damaged"

_STAMP = len("2026-01-31-235959")
_NAME = re.compile(r"\d{4}-\d\d-\d\d-\d{6}-.+")
_Count = Annotated[int, Field(ge=0, le=10**9)]
_Seconds = Annotated[float, Field(ge=0.0, le=1e9)]


class _Recorded(BaseModel):
    model_config = ConfigDict(strict=True, extra="ignore", frozen=True, allow_inf_nan=False)


class RecordedSummary(_Recorded):
    """The used fields of a summary."""

    outcome: Annotated[str, Field(min_length=1)]
    task: str = ""
    robot: str = ""
    scene: str = ""
    seed: int | None = None
    node: str = ""
    localisation: str = ""
    too_slow: str = ""
    duration_s: _Seconds | None = None
    paused_s: _Seconds = 0.0
    placed: _Count | None = None
    objects: _Count | None = None
    attempts: _Count | None = None
    claimed: _Count | None = None
    world: str = ""

    @property
    def handled(self) -> bool:
        """Whether it handled objects."""
        return bool(self.placed or self.claimed or self.attempts)


@dataclass(frozen=True, kw_only=True)
class RunRecord:
    """One run, as read from its folder."""

    folder: Path
    summary: RecordedSummary
    damage: str = ""  # what is wrong with the summary; empty if nothing, or if it is missing

    @property
    def name(self) -> str:
        """Name for other commands, see `find_run`."""
        return self.folder.name if self.folder.parent == RUNS else str(self.folder)

    @property
    def task(self) -> str:
        """Name of the task."""
        return self.summary.task or self.folder.name[_STAMP + 1 :]

    @property
    def silent(self) -> str:
        """Time since the log was last written; a running task writes it every second."""
        try:
            seconds = datetime.now(UTC).timestamp() - getmtime(self.folder / EVENTS)
        except OSError:
            return "without events"
        return f"silent for {in_words(max(0.0, seconds))}"


def find_run(name: str, runs: Path = RUNS) -> Path:
    """The folder of a run: itself, a file in it, its name in `runs`, or `last`.

    Raises UserError: there is no such run.
    """
    if name == LAST:
        folders = run_folders(runs)
        if not folders:
            raise UserError(f"{runs}: no runs here; choose another folder with --runs")
        return folders[-1]
    for path in (Path(name), runs / name):
        folder = path.parent if isfile(path) else path
        if _is_run(folder):
            return folder
    raise UserError(
        f"{name}: no such run; use its folder, a file in it, its name in {runs}/, or `{LAST}`"
    )


def run_folders(runs: Path) -> list[Path]:
    """The folders of all runs, oldest first. Raises UserError: the folder cannot be read."""
    try:
        return sorted((path for path in runs.iterdir() if _is_run(path)), key=_age)
    except FileNotFoundError:
        return []
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise UserError(f"{runs}: no folder of runs ({reason}); name another") from error


def read_run(folder: Path) -> RunRecord:
    """The run in a folder, as far as it can be read."""
    path = folder / SUMMARY
    if not lexists(path):
        return RunRecord(folder=folder, summary=RecordedSummary(outcome=UNFINISHED))
    try:
        if not isfile(path):
            raise OSError(None, "it is no file")
        summary = RecordedSummary.model_validate_json(path.read_bytes())
        return RunRecord(folder=folder, summary=summary)
    except ValidationError as invalid:
        damage = f"{SUMMARY}: {first_problem(invalid)}"
    except OSError as error:
        damage = f"{SUMMARY}: cannot be read ({error.strerror})"
    return RunRecord(folder=folder, summary=RecordedSummary(outcome=DAMAGED), damage=damage)


def read_motion(folder: Path) -> tuple[Array, Array]:
    """States (ticks, 8 + 2 j) and commands (ticks, 4 + j) of a run, see `app.core.files.folder`.

    Raises DamagedRunError: they cannot be read.
    """
    commands = _array(folder / COMMANDS)
    return _array(folder / STATES, 2 * commands.shape[1]), commands


def _array(path: Path, width: int = 0) -> Array:
    """A recorded array (ticks, width), any width from 5 columns if that is 0; no pickles."""
    try:
        if not isfile(path):
            raise ValueError("there is no such file")
        array: npt.NDArray[Any] = whole_rows(path)[0]
        fits = array.ndim == 2 and array.shape[1] == (width or max(5, array.shape[1]))
        if array.dtype != np.float64 or not fits:
            raise ValueError(f"{array.dtype} of shape {array.shape}, not (ticks, columns)")
        if not np.isfinite(array).all():
            raise ValueError("numbers that are not finite")
    except Exception as error:  # of a parser of files that anybody may have made
        why = " ".join(str(error).split())[:100]
        raise DamagedRunError(
            f"{path}: the motion of the run cannot be read ({why}); name another run"
        ) from error
    return array


def runs_table(records: list[RunRecord]) -> Table:
    """A table with a row per run; objects only for runs that handled some."""
    table = Table("run", "outcome", box=None, pad_edge=False)
    table.add_column("time", justify="right")
    table.add_column("placed", justify="right")
    table.add_column("failed in")
    for record in records:
        s, duration = record.summary, record.summary.duration_s
        time = "-" if duration is None else task_time(duration, s.paused_s)
        time = record.silent if s.outcome == UNFINISHED else time
        placed = f"{s.placed or 0} of {s.objects}" if s.objects is not None else f"{s.claimed or 0}"
        placed = placed if s.handled else "-"
        table.add_row(record.name, s.outcome, time, placed, s.node)
    return table


def _is_run(folder: Path) -> bool:
    """Whether a folder has the name or a file of a run."""
    if not isdir(folder):
        return False
    left = (RECORDING, "task.yaml", EVENTS, SUMMARY)
    return bool(_NAME.fullmatch(folder.name)) or any(isfile(folder / name) for name in left)


def _age(folder: Path) -> tuple[str, float]:
    """Sort key: the second in the folder's name, then when its task file was written."""
    task = folder / "task.yaml"
    return folder.name[:_STAMP], getmtime(task) if isfile(task) else 0.0
