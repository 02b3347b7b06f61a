"""Pause, resume, step and stop: set by any thread, read by the session's loop."""

from __future__ import annotations

import threading
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class ControlState:
    """The state of a run for its controls."""

    paused: bool
    why: str
    """What paused it; empty if it is not paused."""
    stopped: bool
    ticks: int
    """Number of ticks of the tree."""


class Control:
    """The object through which people control the session's loop.

    While paused, the loop continues and brings the robot to rest, but the tree is not ticked and
    its clock stands still. A step is one tick of the tree, with one control period of the motion
    that it requests.

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
        """The current state."""
        with self._changed:
            return ControlState(
                paused=self._paused, why=self._why, stopped=self._stopped, ticks=self._ticks
            )

    @property
    def stopped(self) -> bool:
        """Whether the run is to end."""
        return self._stopped

    # for people, from any thread

    def pause(self, why: str = "by a person") -> None:
        """Stop ticking the tree until `resume` or `step`."""
        with self._changed:
            if not self._paused:
                self._why = why
            self._paused = True
            self._steps = 0
            self._to_next_change = False

    def resume(self) -> None:
        """Continue where the run was paused."""
        with self._changed:
            self._resume()

    def toggle(self) -> None:
        """Pause, or resume if paused."""
        with self._changed:
            if self._paused:
                self._resume()
            else:
                self.pause()

    def step(self) -> None:
        """Tick the tree once, then pause; steps requested in quick succession add up."""
        with self._changed:
            if not self._paused:
                self.pause()
            self._steps += 1
            self._changed.notify_all()

    def run_to_next_change(self) -> None:
        """Continue until a node of the tree changes its status, then pause."""
        with self._changed:
            self._resume()
            self._to_next_change = True

    def stop(self) -> None:
        """End the run; the robot is brought to rest first."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()

    # for the loop

    def take_turn(self) -> bool:
        """Whether the tree is ticked in this cycle of the loop; consumes a step."""
        with self._changed:
            if self._paused and self._steps == 0:
                return False
            self._steps = max(0, self._steps - 1)
            self._ticks += 1
            return True

    def node_changed(self) -> None:
        """Report that the last tick changed the status of a node."""
        with self._changed:
            if self._to_next_change:
                self.pause("at a status change")

    def wait(self, seconds: float) -> None:
        """Wait in real time while paused; return early on resume, step or stop.

        Args:
            seconds: longest wait [s].
        """
        with self._changed:
            self._changed.wait_for(
                lambda: not self._paused or self._steps > 0 or self._stopped, max(0.0, seconds)
            )

    def _resume(self) -> None:
        self._paused, self._why, self._steps = False, "", 0
        self._to_next_change = False
        self._changed.notify_all()
