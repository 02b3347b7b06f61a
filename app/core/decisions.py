"""Decisions of people (turns, stops, acknowledgements), recorded and replayed."""

from typing import TypeAlias

from app.live import Control
from hw import RecordedRobot, ReplayRobot, Turn


class RecordedDecisions:
    """Asks the controls of a run and records the answers with the robot's readings."""

    def __init__(self, control: Control, robot: RecordedRobot) -> None:
        self.attended = control.attended
        self.pause, self.wait = control.pause, control.wait
        self._control, self._robot = control, robot

    @property
    def stopped(self) -> bool:
        """See `Control`."""
        stopped = self._control.stopped
        if stopped:
            self._robot.note_stopped()
        return stopped

    def take_turn(self) -> bool:
        """See `Control`."""
        turn = self._control.take_turn()
        self._robot.note_turn(Turn.TREE if turn else Turn.PAUSED)
        return turn

    def emergency_stop(self, text: str, *, pressed: bool) -> bool:
        """See `Control`."""
        acknowledged = self._control.emergency_stop(text, pressed=pressed)
        if acknowledged:
            self._robot.note_acknowledged()
        return acknowledged


class ReplayedDecisions:
    """Repeats the recorded decisions of a run.

    `attended` is whether somebody could acknowledge an emergency stop.
    """

    def __init__(self, robot: ReplayRobot, *, attended: bool) -> None:
        self.attended = attended
        self._robot = robot

    @property
    def stopped(self) -> bool:
        """See `Control`."""
        row = self._robot.next_row
        return row is not None and bool(row["stopped"])

    def take_turn(self) -> bool:
        """See `Control`."""
        return int(self._robot.row["turn"]) == Turn.TREE

    def emergency_stop(self, text: str, *, pressed: bool) -> bool:
        """See `Control`."""
        return bool(self._robot.row["acknowledged"])

    def pause(self, why: str) -> None:
        """Do nothing: the recorded turns contain the pause."""

    def wait(self, seconds: float) -> None:
        """Do nothing: a replay does not wait."""


Decisions: TypeAlias = Control | RecordedDecisions | ReplayedDecisions  # what the loop asks people
