"""Folder of a run: names of its files, and how it is made."""

import json
from collections.abc import Mapping
from datetime import datetime
from os.path import relpath
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

from config import UserError
from robots import robot_texts
from trees.language import Task

RECORDING = "recording.rrd"
SUMMARY = "summary.json"
TASK = "task.yaml"  # the task as it was run; its subtrees lie beside it
PLACES = "places.yaml"
OPTIONS = "options.json"  # the options of the run
_ROBOT = "robot"  # folder with the description of the robot as it was
VIEWER_LOG = "viewer.log"  # messages of the viewer
COMMANDS = "commands.npy"
"""(ticks, 4 + j) float64: stamp [s], base twist (3), j joint velocities, as applied."""
STATES = "states.npy"
"""(ticks, 8 + 2 j) float64, as read: stamp [s], base x, y [m] and heading [rad], base twist (3), j
joint positions and j velocities, width between the fingers [m]."""
READINGS = "readings.npy"
"""(turns,) of type `hw.turn_type`: all that passed between loop and robot, without images."""
NOTES = "readings.jsonl"
"""JSON lines: columns of the arrays, what the readings refer to (faults, localised poses, scans),
and how they end."""
FRAMES = "frames.arrow"  # images that the loop used, as a stream of Arrow record batches

_STAMP = "%Y-%m-%d-%H%M%S"  # when a run began, at the front of its folder's name
_MIN_SPACE = 1_000_000  # free disk space that a run needs to begin [bytes]


def columns(j: int) -> dict[str, list[str]]:
    """Names of the columns of `STATES` and `COMMANDS`, for an arm of j joints."""
    q, qd = ([f"{one}{number}" for number in range(1, j + 1)] for one in ("q", "qd"))
    twist = ["vx", "vy", "w"]
    states = ["stamp", "x", "y", "heading", *twist, *q, *qd, "width"]
    return {STATES: states, COMMANDS: ["stamp", *twist, *qd]}


def make_folder(root: Path, task: str, texts: Mapping[str, str], options: dict[str, Any]) -> Path:
    """A new folder `<time>-<task>` in `root`, with the task's files and `options.json`.

    Raises UserError: it cannot be written.
    """
    stamp = datetime.now().strftime(_STAMP)
    try:
        root.mkdir(parents=True, exist_ok=True)
        folder = _new_folder(root / f"{stamp}-{task}")
        with TemporaryFile(dir=folder) as file:  # on a full disk Rerun would hang
            file.write(bytes(_MIN_SPACE))
        for name, text in texts.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text, encoding="utf-8")
        options_text = json.dumps(options, indent=2, default=str)
        (folder / OPTIONS).write_text(options_text + "\n", encoding="utf-8")
    except OSError as error:
        raise UserError(
            f"{root}: cannot keep the run here ({error.strerror}); choose another with --record"
        ) from error
    return folder


def _new_folder(wanted: Path) -> Path:
    """Make a folder; with a number if another run has begun at the same moment."""
    folder, number = wanted, 1
    while True:
        try:
            folder.mkdir()
        except FileExistsError:
            number += 1
            folder = wanted.with_name(f"{wanted.name}-{number}")
        else:
            return folder


def begun(folder: Path) -> int:
    """When a run began, by the name of its folder [ns since 1970]; 0 if that does not tell."""
    try:
        return int(datetime.strptime(folder.name[:17], _STAMP).timestamp()) * 10**9
    except ValueError:
        return 0


def recorded_robot(folder: Path, options: Mapping[str, Any]) -> str:
    """The file of the robot of a run, as it was then; of an older run that in its options."""
    return str(next((folder / _ROBOT).glob("*.yaml"), options["robot"]))


def texts(task: Task, places: Path | None, robot: str) -> dict[str, str]:
    """Files of a run by path: `task.yaml`, the places, subtrees as they lie beside, the robot."""
    site = {} if places is None else {PLACES: places.read_text(encoding="utf-8")}
    here = task.path.parent
    inner = {relpath(path, here): path.read_text(encoding="utf-8") for path in task.files[1:]}
    body = {f"{_ROBOT}/{name}": text for name, text in robot_texts(robot).items()}
    return inner | site | body | {TASK: task.text}
