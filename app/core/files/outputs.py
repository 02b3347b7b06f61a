"""Files that a run writes beside the recording: events, commands, states, readings."""

import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from app.core.files.disk import PATIENCE, Disk
from app.core.files.events import EVENTS, EventLog
from app.core.files.folder import COMMANDS, FRAMES, NOTES, READINGS, STATES, columns
from app.core.files.frames import FrameStream
from app.core.files.notes import note
from app.core.outcome import Outcome
from app.live import Snapshot, colour_png, depth_png
from hw import DepthFrame, RecordedRobot, turn_type
from trees.language import TreeNode

_FRAME_CAPACITY = 60  # most frames that wait for a slow disk


class Outputs:
    """Writes the files of a run; also receives what passes between loop and robot.

    `attended` tells whether a person can acknowledge an emergency stop, `lossless` whether the loop
    waits for a slow disk, `frames` whether to keep the camera's images, which are large. Raises
    UserError: a file cannot be written.
    """

    def __init__(
        self,
        folder: Path,
        *,
        task: str,
        nodes: Sequence[TreeNode],
        robot: RecordedRobot,
        attended: bool,
        lossless: bool,
        frames: bool,
    ) -> None:
        self._robot = robot
        self._disk = disk = Disk(folder, lossless=lossless)
        self._events = EventLog(disk.file(EVENTS), task, nodes)
        j = len(robot.description.arm.joints)
        named, turn = columns(j), turn_type(j)
        self._turns = [disk.array(READINGS, turn)]
        for name, encode in ((STATES, _states), (COMMANDS, _commands)):
            row = np.float64, (len(named[name]),)
            self._turns.append(disk.array(name, row, partial(encode, turn)))
        self._notes = disk.file(NOTES)
        self._note({"attended": attended, "columns": named})
        self._frame_disk = None
        if frames:
            self._frame_disk = Disk(folder, lossless=lossless, capacity=_FRAME_CAPACITY)
            self._frames = self._frame_disk.file(FRAMES, FrameStream())
        robot.record(self)

    def update(self, seen: Snapshot) -> None:
        """Write the changes of a tick."""
        self._events.update(seen)

    def picture(self, name: str, frame: DepthFrame) -> None:
        """Write a picture that the task keeps."""
        self._disk.file(f"{name}.depth.png", depth_png).add(frame)
        if frame.paint is not None:
            self._disk.file(f"{name}.png", colour_png).add(frame)

    def turn(self, row: npt.NDArray[np.void]) -> None:
        """Write one cycle of the loop, a row of `turn_type`."""
        data = row.tobytes()
        for file in self._turns:
            file.add(data)

    def thing(self, field: str, number: int, thing: Any) -> None:
        """Write what a number in the readings stands for; frames only if they are kept."""
        if field != "frame":
            self._note(note(field, number, thing))
        elif self._frame_disk is not None:
            self._frames.add((number, thing))

    def end(self, outcome: Outcome, time: float) -> None:
        """Write how the run ended, at a time on the session's clock [s]."""
        self._events.end(outcome, time)
        self._robot.end()
        self._note({"end": self._robot.broken or "complete"})

    def close(self, patience: float = PATIENCE) -> list[str]:
        """Write the rest within a time [s]; returns what could not be written, a line each."""
        problems = self._disk.close(patience)
        return problems + (self._frame_disk.close(patience) if self._frame_disk else [])

    def _note(self, line: dict[str, object]) -> None:
        self._notes.add((json.dumps(line) + "\n").encode())


def _states(turn: np.dtype[np.void], pieces: Sequence[bytes]) -> bytes:
    """Turns as rows of `STATES`."""
    turns = np.frombuffer(b"".join(pieces), turn)
    read = turns[turns["read"]]
    oTb = read["wTb"]
    base = read["stamp"], oTb[:, :2, 3], np.arctan2(oTb[:, 1, 0], oTb[:, 0, 0]), read["base_twist"]
    return np.column_stack([*base, read["q"], read["qd"], read["width"]]).tobytes()


def _commands(turn: np.dtype[np.void], pieces: Sequence[bytes]) -> bytes:
    """Turns as rows of `COMMANDS`."""
    turns = np.frombuffer(b"".join(pieces), turn)
    sent = turns[turns["sent"]]
    stamps = np.where(sent["read"], sent["stamp"], sent["sent_time"])
    return np.column_stack([stamps, sent["applied"]]).tobytes()
