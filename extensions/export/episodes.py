"""Episodes of a run: one for each object, and one for each attempt that failed.

A run of a task that places objects is cut where an object was released at its place, and where a
grasp, its check or a placement failed; the rest is an episode if a grasp began in it. A run of any
other task is one episode.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from os.path import isfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from app.core import End
from app.review import DamagedRunError, Timeline, read_log, read_motion, read_run, timeline
from config import Diagnostics, UserError, content, counted, read_yaml


class ExportError(UserError):
    """Runs cannot be exported; the text says which and why."""


_SHORTEST, _LONGEST = 1e-4, 1.0  # of a control period [s]
_LEAST_FRAMES = 2
_HANDLING = ("grasp", "retreat_check", "place")

Array = npt.NDArray[Any]


@dataclass(frozen=True, kw_only=True)
class Part:
    """Interval of an episode in a run, on the session's clock [s]."""

    begin: float
    end: float
    success: bool
    why: str


@dataclass(frozen=True, kw_only=True)
class Episode:
    """One episode."""

    task: str
    robot: str
    success: bool
    why: str
    folder: Path
    stamps: Array  # (frames,) on the session's clock [s]
    columns: dict[str, Array]  # (frames,) or (frames, n) by feature, without the indices

    @property
    def length(self) -> int:
        """Number of frames."""
        return len(self.stamps)


def read_episodes(folder: Path, fps: int) -> list[Episode]:
    """The episodes of one run at a frame rate that divides the control rate.

    Raises ExportError: it has no recorded motion, is too short, or has another rate.
    """
    states, commands = read_motion(folder)
    count = min(len(states), len(commands))
    if count < 2:
        raise ExportError(f"{folder}: too short a run ({counted(count, 'tick')}); name another")
    period = float(np.median(np.diff(states[:count, 0])))
    if not _SHORTEST <= period <= _LONGEST:
        raise ExportError(f"{folder}: its stamps are {period:g} s apart; name another run")
    rate = round(1.0 / period)
    if fps < 1 or rate % fps:
        fitting = ", ".join(str(n) for n in range(1, rate + 1) if rate % n == 0)
        raise ExportError(f"--fps {fps}: {folder} has {rate} ticks per second; choose {fitting}")
    states, commands = states[: count : rate // fps], commands[: count : rate // fps]
    episodes = []
    for part in parts_of(folder, float(states[-1, 0])):
        inside = (part.begin <= states[:, 0]) & (states[:, 0] <= part.end)
        if inside.sum() >= _LEAST_FRAMES:
            episodes.append(_episode(folder, part, states[inside], commands[inside], fps))
    return episodes


def parts_of(folder: Path, end: float) -> list[Part]:
    """The parts of a run whose last reading is at `end` [s]."""
    outcome = read_run(folder).summary.outcome
    whole = Part(begin=0.0, end=end, success=outcome == End.SUCCESS.value, why=outcome)
    try:
        run = timeline(read_log(folder))
    except DamagedRunError:
        return [whole]
    if all(node.kind != "place" for node in run.nodes):
        return [whole]
    parts: list[Part] = []
    begin = 0.0
    for time, success, why in _cuts(run):
        parts.append(Part(begin=begin, end=time, success=success, why=why))
        begin = time
    if any(span.begin > begin for span in _rounds(run, ("grasp",))) or not parts:
        parts.append(Part(begin=begin, end=end, success=False, why=f"the run ended: {outcome}"))
    return parts


def _cuts(run: Timeline) -> list[tuple[float, bool, str]]:
    """Times at which an object was placed or an attempt failed, with success and message."""
    found = [
        (span.end, span.status == "SUCCESS", span.message)
        for span in _rounds(run, _HANDLING)
        if span.status == "FAILURE"
        or (span.status == "SUCCESS" and run.nodes[span.node].kind == "place")
    ]
    return sorted(found)


def _rounds(run: Timeline, kinds: Sequence[str]) -> list[Any]:
    return [
        span
        for node, rounds in run.rounds.items()
        if run.nodes[node].kind in kinds
        for span in rounds
    ]


def _episode(folder: Path, part: Part, states: Array, commands: Array, fps: int) -> Episode:
    j = commands.shape[1] - 4
    pose, twist, q, qd, fingers = np.split(states[:, 1:], [3, 6, 6 + j, 6 + 2 * j], axis=1)
    later = np.concatenate([fingers[1:], fingers[-1:]])
    record = read_run(folder)
    last = np.arange(len(states)) == len(states) - 1
    return Episode(
        task=_description(folder) or record.task,
        robot=record.summary.robot or "frankie",
        success=part.success,
        why=part.why,
        folder=folder,
        stamps=states[:, 0],
        columns={
            "observation.state": np.hstack([pose, q, fingers]).astype(np.float32),
            "observation.velocity": np.hstack([twist, qd]).astype(np.float32),
            "action": np.hstack([commands[:, 1:], later]).astype(np.float32),
            "next.done": last,
            "next.success": last & part.success,
            "timestamp": (np.arange(len(states)) / fps).astype(np.float32),
        },
    )


def _description(folder: Path) -> str:
    """The description in the task file; empty if there is none."""
    path = folder / "task.yaml"
    read = read_yaml(Diagnostics(path)) if isfile(path) else None
    task = content(read[1]) if read is not None else None
    description = task.get("description") if isinstance(task, dict) else None
    return description if isinstance(description, str) else ""
