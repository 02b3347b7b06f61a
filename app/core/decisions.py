"""Decisions of people (turns, stops, acknowledgements), recorded and replayed."""

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
    """Asks the controls of a run and records the answers with the robot's readings."""

    def __init__(self, control: Control, robot: RecordedRobot) -> None:
        self.attended = control.attended
        self.pause, self.wait = control.pause, control.wait
        self._control, self._robot = control, robot

    @property
    def stopped(self) -> bool:
        """See `Decisions`."""
        stopped = self._control.stopped
        if stopped:
            self._robot.note_stopped()
        return stopped

    def take_turn(self) -> bool:
        """See `Decisions`."""
        turn = self._control.take_turn()
        self._robot.note_turn(Turn.TREE if turn else Turn.PAUSED)
        return turn

    def emergency_stop(self, text: str, *, pressed: bool) -> bool:
        """See `Decisions`."""
        acknowledged = self._control.emergency_stop(text, pressed=pressed)
        if acknowledged:
            self._robot.note_acknowledged()
        return acknowledged


class ReplayedDecisions:
    """Repeats the recorded decisions of a run.

    Args:
        robot: replays that run.
        attended: whether somebody could acknowledge an emergency stop.
    """

    def __init__(self, robot: ReplayRobot, *, attended: bool) -> None:
        self.attended = attended
        self._robot = robot

    @property
    def stopped(self) -> bool:
        """See `Decisions`."""
        row = self._robot.next_row
        return row is not None and bool(row["stopped"])

    def take_turn(self) -> bool:
        """See `Decisions`."""
        return int(self._robot.row["turn"]) == Turn.TREE

    def emergency_stop(self, text: str, *, pressed: bool) -> bool:
        """See `Decisions`."""
        return bool(self._robot.row["acknowledged"])

    def pause(self, why: str) -> None:
        """Do nothing: the recorded turns contain the pause."""

    def wait(self, seconds: float) -> None:
        """Do nothing: a replay does not wait."""
