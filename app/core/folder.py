"""The folder that a run leaves: recording, summary, commands, and the task and options as run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import datetime
from os.path import relpath
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

from config import UserError
from trees.language import Task

RECORDING = "recording.rrd"
SUMMARY = "summary.json"
TASK = "task.yaml"
PLACES = "places.yaml"
"""The task as it was run; its subtrees lie beside it."""
OPTIONS = "options.json"
"""What a person chose."""
BT_LOG = "tree.btlog"
"""The status of every node over time, as Groot2 replays it."""
VIEWER_LOG = "viewer.log"
"""What a viewer that was started for the run had to say."""
COMMANDS = "commands.npy"
"""(ticks, 11) float64: stamp [s], base twist (3), joint velocities (7) as they were applied."""
STATES = "states.npy"
"""(ticks, 22) float64, as read: stamp [s], base x, y [m] and heading [rad], base twist (3), joint
positions (7) and velocities (7), width between the fingers [m]."""
READINGS = "readings.npy"
"""(turns,) `hw.TURN`: everything that passed between loop and robot but the images."""
NOTES = "readings.jsonl"
"""What the readings refer to, an object a line: each set of faults, and how the readings end."""
FRAMES = "frames.arrow"
"""The camera's images that the loop was given, as a stream of Arrow record batches."""


_LEAST_ROOM = 1_000_000
"""What must be free before a run begins [bytes]; the first seconds of a recording take half."""


class FolderError(UserError):
    """The folder of a run cannot be made."""


def make_folder(root: Path, task: str, texts: Mapping[str, str], options: dict[str, Any]) -> Path:
    """A new folder `<time>-<task>` with the task's files and the options of the run in it.

    Args:
        root: where to make it; made too if need be.
        task: name of the task.
        texts: the task's files, by their paths in the folder.
        options: what a person chose, for `options.json`.

    Raises:
        FolderError: it cannot be written.
    """
    stamp = datetime.now().strftime("%Y-%m-%d-%H%M%S")
    try:
        root.mkdir(parents=True, exist_ok=True)
        number = 1
        folder = root / f"{stamp}-{task}"
        while not _made(folder):
            number += 1
            folder = root / f"{stamp}-{task}-{number}"
        _require_room(folder)
        for name, text in texts.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text, encoding="utf-8")
        options_text = json.dumps(options, indent=2, default=str)
        (folder / OPTIONS).write_text(options_text + "\n", encoding="utf-8")
    except OSError as error:
        raise FolderError(
            f"{root}: cannot keep the run here ({error.strerror}); choose another with --record"
        ) from error
    return folder


def _require_room(folder: Path) -> None:
    """Raise OSError unless a file of the least size can be written there.

    A disk that fills later costs a recording its end. On one that is full from the start Rerun
    waits for a thread of its own that has already ended.
    """
    with TemporaryFile(dir=folder) as file:
        file.write(bytes(_LEAST_ROOM))


def _made(folder: Path) -> bool:
    """Make a folder; False if there is one: another run may begin at the same moment."""
    try:
        folder.mkdir()
    except FileExistsError:
        return False
    return True


def texts(task: Task, places: Path | None) -> dict[str, str]:
    """The files of a task, the first as `task.yaml` and its subtrees where they are beside it."""
    site = {} if places is None else {PLACES: places.read_text(encoding="utf-8")}
    here = task.path.parent
    inner = {relpath(path, here): path.read_text(encoding="utf-8") for path in task.files[1:]}
    return inner | site | {TASK: task.text}
