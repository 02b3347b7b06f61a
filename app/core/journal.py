"""What passes between loop and robot, kept in the run's folder for people and for a replay."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
import numpy.typing as npt

from app.core.disk import Disk
from app.core.folder import COMMANDS, FRAMES, NOTES, READINGS, STATES
from app.core.frames import FrameStream
from hw import TURN, DepthFrame, Fault

_FRAME_CAPACITY = 60
"""Frames that wait for a slow disk at most."""


class Journal:
    """Writes commands, states and readings, and the camera's frames on request.

    Args:
        folder: of the run.
        disk: writes everything but the frames.
        attended: whether a person can acknowledge an emergency stop.
        lossless: as for `Disk`.
        frames: whether to keep the frames, which are large.

    Raises:
        FolderError: a file cannot be written.
    """

    def __init__(
        self, folder: Path, disk: Disk, *, attended: bool, lossless: bool, frames: bool
    ) -> None:
        self._commands = disk.array(COMMANDS, (np.float64, (11,)))
        self._states = disk.array(STATES, (np.float64, (22,)))
        self._readings = disk.array(READINGS, TURN)
        self._notes = disk.file(NOTES)
        self._note({"attended": attended})
        self._frame_disk = None
        if frames:
            self._frame_disk = Disk(folder, lossless=lossless, capacity=_FRAME_CAPACITY)
            self._frames = self._frame_disk.file(FRAMES, FrameStream())

    def turn(self, row: npt.NDArray[np.void]) -> None:
        """Keep a turn."""
        self._readings.add(row.tobytes())
        if row["read"]:
            wTb = row["wTb"]
            heading = np.arctan2(wTb[1, 0], wTb[0, 0])
            base = (row["stamp"], wTb[0, 3], wTb[1, 3], heading, *row["base_twist"])
            state = np.array([*base, *row["q"], *row["qd"], row["width"]])
            self._states.add(state.tobytes())
        if row["sent"]:
            stamp = row["stamp"] if row["read"] else row["sent_time"]
            self._commands.add(np.array([stamp, *row["applied"]]).tobytes())

    def faults(self, number: int, faults: tuple[Fault, ...]) -> None:
        """Keep what a number in the readings stands for."""
        described = [asdict(fault) | {"kind": fault.kind.name} for fault in faults]
        self._note({"number": number, "faults": described})

    def frame(self, number: int, frame: DepthFrame) -> None:
        """Keep a frame, if frames are kept."""
        if self._frame_disk is not None:
            self._frames.add((number, frame))

    def end(self, broken: str) -> None:
        """Note that the readings are complete, or why they are of no use for a replay."""
        self._note({"end": broken or "complete"})

    def close(self, patience: float) -> list[str]:
        """Finish the frames within a time [s]; returns what went wrong with them."""
        return self._frame_disk.close(patience) if self._frame_disk is not None else []

    def _note(self, note: dict[str, object]) -> None:
        self._notes.add((json.dumps(note) + "\n").encode())
