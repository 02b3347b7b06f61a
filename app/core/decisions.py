"""What people decide about a run, noted for a replay and given back in one."""

from __future__ import annotations

from typing import Protocol

from app.live import Control
from hw import RecordedRobot, ReplayRobot, Turn


class Decisions(Protocol):
    """What the loop asks people; `app.live.Control` is one."""

    @property
    def stopped(self) -> bool:
        """Whether the run is to end."""

    @property
    def attended(self) -> bool:
        """Whether a person, or a stand-in for tests, can acknowledge and resume."""

    def take_turn(self) -> bool:
        """Whether the tree is ticked in this cycle of the loop."""

    def emergency_stop(self, text: str, *, pressed: bool) -> bool:
        """Report an emergency stop at every tick; whether a person has acknowledged it since."""

    def pause(self, why: str) -> None:
        """Stop ticking the tree until a person resumes."""

    def wait(self, seconds: float) -> None:
        """Wait in real time while paused [s]."""


class RecordedDecisions:
    """What people decide, noted beside the readings.

    Args:
        control: who asks them.
        robot: whose turns are noted.
    """

    def __init__(self, control: Control, robot: RecordedRobot) -> None:
        self._control = control
        self._robot = robot

    @property
    def stopped(self) -> bool:
        """Whether the run is to end."""
        stopped = self._control.stopped
        if stopped:
            self._robot.note_stopped()
        return stopped

    @property
    def attended(self) -> bool:
        """Whether a person, or a stand-in for tests, can acknowledge and resume."""
        return self._control.attended

    def take_turn(self) -> bool:
        """Whether the tree is ticked in this cycle of the loop."""
        turn = self._control.take_turn()
        self._robot.note_turn(Turn.TREE if turn else Turn.PAUSED)
        return turn

    def emergency_stop(self, text: str, *, pressed: bool) -> bool:
        """Report an emergency stop at every tick; whether a person has acknowledged it since."""
        acknowledged = self._control.emergency_stop(text, pressed=pressed)
        if acknowledged:
            self._robot.note_acknowledged()
        return acknowledged

    def pause(self, why: str) -> None:
        """Stop ticking the tree until a person resumes."""
        self._control.pause(why)

    def wait(self, seconds: float) -> None:
        """Wait in real time while paused [s]."""
        self._control.wait(seconds)


class ReplayedDecisions:
    """What people decided in a recorded run.

    Args:
        robot: gives back that run.
        attended: whether somebody could acknowledge an emergency stop.
    """

    def __init__(self, robot: ReplayRobot, *, attended: bool) -> None:
        self.attended = attended
        self._robot = robot

    @property
    def stopped(self) -> bool:
        """Whether the run was ended here."""
        row = self._robot.next_row
        return row is not None and bool(row["stopped"])

    def take_turn(self) -> bool:
        """Whether the tree was ticked here."""
        return int(self._robot.row["turn"]) == Turn.TREE

    def emergency_stop(self, text: str, *, pressed: bool) -> bool:
        """Whether an emergency stop was acknowledged here."""
        return bool(self._robot.row["acknowledged"])

    def pause(self, why: str) -> None:
        """What came of it is in the turns."""

    def wait(self, seconds: float) -> None:
        """Nobody is waited for."""
