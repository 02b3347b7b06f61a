"""What people ask of a run: pause, go on, one step, stop. Asked by the loop, told by any thread."""

from __future__ import annotations

import threading
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class ControlState:
    """How a run stands, for those who control it."""

    paused: bool
    why: str
    """What paused it; empty if nothing did."""
    stopped: bool
    ticks: int
    """How often the tree was ticked."""


class Control:
    """The one object between the session's loop and whoever controls it.

    While paused, the loop goes on and brings the robot to rest, but the tree is not ticked; its
    clock stands still meanwhile (see `TaskClock`). A step is one tick of the tree, with the motion
    that it asks for during one control period.

    Args:
        paused: whether the run waits for a person before its first tick.
    """

    def __init__(self, *, paused: bool = False) -> None:
        self._changed = threading.Condition()  # re-entrant: a signal handler may come in between
        self._paused = paused
        self._why = "before the first tick" if paused else ""
        self._steps = 0
        self._to_next_change = False
        self._stopped = False
        self._ticks = 0

    @property
    def state(self) -> ControlState:
        """How it stands now."""
        with self._changed:
            return ControlState(
                paused=self._paused, why=self._why, stopped=self._stopped, ticks=self._ticks
            )

    @property
    def stopped(self) -> bool:
        """Whether a person wants the run to end."""
        return self._stopped

    # for people, from any thread

    def pause(self, why: str = "by a person") -> None:
        """Do not tick the tree any more until told otherwise."""
        with self._changed:
            if not self._paused:
                self._why = why
            self._paused = True
            self._steps = 0
            self._to_next_change = False

    def resume(self) -> None:
        """Go on where the run was paused."""
        with self._changed:
            self._let_go()

    def toggle(self) -> None:
        """Pause, or go on if paused."""
        with self._changed:
            if self._paused:
                self._let_go()
            else:
                self.pause()

    def step(self) -> None:
        """Tick the tree once and be paused then; steps that come quickly add up."""
        with self._changed:
            if not self._paused:
                self.pause()
            self._steps += 1
            self._changed.notify_all()

    def run_to_next_change(self) -> None:
        """Go on until some node of the tree changes its status, and be paused then."""
        with self._changed:
            self._let_go()
            self._to_next_change = True

    def stop(self) -> None:
        """End the run; the robot is brought to rest first."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()

    # for the loop

    def take_turn(self) -> bool:
        """Whether the tree is ticked in this turn of the loop; uses up a step."""
        with self._changed:
            if self._paused and self._steps == 0:
                return False
            self._steps = max(0, self._steps - 1)
            self._ticks += 1
            return True

    def node_changed(self) -> None:
        """Tell that the last tick changed the status of some node."""
        with self._changed:
            if self._to_next_change:
                self.pause("at a change of the tree")

    def wait(self, seconds: float) -> None:
        """Let real time pass while paused; returns early when somebody wants something.

        Args:
            seconds: how long at most [s].
        """
        with self._changed:
            self._changed.wait_for(
                lambda: not self._paused or self._steps > 0 or self._stopped, max(0.0, seconds)
            )

    def _let_go(self) -> None:
        self._paused, self._why, self._steps = False, "", 0
        self._to_next_change = False
        self._changed.notify_all()
