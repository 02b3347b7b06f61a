"""Pause, resume, step and stop: set by any thread, read by the session's loop."""

import threading
from dataclasses import dataclass, replace
from typing import Any

ACKNOWLEDGED = "emergency stop acknowledged"


@dataclass(frozen=True, kw_only=True)
class ControlState:
    """State of a run for its controls."""

    paused: bool
    why: str  # reason of the pause; empty if it is not paused
    ticks: int = 0
    emergency: str = ""  # the unacknowledged emergency stop; else empty
    pressed: bool = False


class Control:
    """Pauses, steps and stops the session's loop.

    While paused, the loop continues and brings the robot to rest, but the tree is not ticked and
    its clock stands still. A step is one tick of the tree, with one control period of the motion
    that it requests. After an emergency stop the run is paused, and can be resumed only when the
    button is released and a person has acknowledged the stop.

    `paused` waits for a person before the first tick; `attended` is whether a person, or a stand-in
    for tests, can acknowledge and resume.
    """

    def __init__(self, *, paused: bool = False, attended: bool = True) -> None:
        self.attended = attended
        self.stopped = False
        """Whether the run is to end; not in the state, as a signal handler sets it at any time."""
        self.state = ControlState(paused=paused, why="before the first tick" if paused else "")
        self._changed = threading.Condition()  # re-entrant: a signal handler may come in between
        self._steps = 0
        self._to_next_change = False
        self._acknowledged = False

    # for people, from any thread

    def pause(self, why: str = "by a person") -> None:
        """Stop ticking the tree until `resume` or `step`."""
        with self._changed:
            self._set(paused=True, why=self.state.why if self.state.paused else why)
            self._steps, self._to_next_change = 0, False

    def resume(self) -> None:
        """Continue after a pause."""
        with self._changed:
            self._resume()

    def step(self) -> None:
        """Tick the tree once, then pause; quick requests add up."""
        with self._changed:
            if not self.state.paused:
                self.pause()
            if not self.state.emergency:
                self._steps += 1
                self._changed.notify_all()

    def run_to_next_change(self) -> None:
        """Continue until the status of a node changes, then pause."""
        with self._changed:
            self._to_next_change = self._resume()

    def acknowledge(self) -> None:
        """Confirm that the emergency is over; ignored while the button is pressed."""
        with self._changed:
            self._acknowledged = bool(self.state.emergency) and not self.state.pressed

    def stop(self) -> None:
        """End the run; the robot is brought to rest first."""
        with self._changed:
            self.stopped = True
            self._changed.notify_all()

    # for the loop

    def take_turn(self) -> bool:
        """Whether the tree is ticked in this cycle of the loop; consumes a step."""
        with self._changed:
            if self.state.paused and self._steps == 0:
                return False
            self._steps = max(0, self._steps - 1)
            self._set(ticks=self.state.ticks + 1)
            return True

    def emergency_stop(self, text: str, *, pressed: bool) -> bool:
        """Report an unacknowledged emergency stop; whether a person has acknowledged it since."""
        with self._changed:
            self._steps, self._to_next_change = 0, False
            acknowledged = self._acknowledged and bool(self.state.emergency) and not pressed
            self._acknowledged = False
            if acknowledged:
                self._set(paused=True, why=ACKNOWLEDGED, emergency="", pressed=False)
            else:
                why = text if pressed else f"{text}: released, not yet acknowledged"
                self._set(paused=True, why=why, emergency=text, pressed=pressed)
            return acknowledged

    def node_changed(self, changed: bool = True) -> None:
        """Report whether the last tick changed the status of a node."""
        with self._changed:
            if changed and self._to_next_change:
                self.pause("at a status change")

    def wait(self, seconds: float) -> None:
        """Wait in real time while paused [s]; return early on resume, step or stop."""
        with self._changed:
            self._changed.wait_for(
                lambda: not self.state.paused or self._steps > 0 or self.stopped, max(0.0, seconds)
            )

    def _set(self, **changes: Any) -> None:
        self.state = replace(self.state, **changes)

    def _resume(self) -> bool:
        if self.state.emergency:
            return False
        self._set(paused=False, why="")
        self._steps, self._to_next_change = 0, False
        self._changed.notify_all()
        return True
