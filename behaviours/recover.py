"""Behaviour `recover`: clear faults, leave contacts, and fold the arm."""

from collections.abc import Callable
from functools import partial
from math import degrees
from typing import ClassVar

import numpy as np
from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.fault_memory import WayOut
from behaviours.core.leaf import Leaf
from behaviours.core.motion import AWAY_SPEED, IN_THE_WAY, BackOff, Progress, Rise
from behaviours.core.parameter_types import Posture
from config import counted
from controller import PostureGoal

_FOLDED = 0.05  # an arm that is nearer to the posture need not rise first [rad]
_MOST_BACK_OFFS = 2
_REST = 0.5  # of an arm that folds: what is in its way stays there [s]
_RISE = 0.15  # of the hand, before the arm folds [m]


class Recover(Leaf):
    """Clear what a program may clear, get away from what was hit, fold the arm.

    With nothing to clear and no posture to come back to it succeeds at once. A fault is cleared
    after a pause: 0.5 s for the first one, at least 2 s and then 8 s after the one before. Then a
    base that was touched drives slowly away from that side, or back along where it came from, as
    does one that drove the arm into something; else a hand goes back the way that it came, and up.
    What was hit counts as standing there for five minutes. What comes back at the same place after
    three times waits for a person: the run pauses, or ends where nobody is there. Where furniture
    is in the arm's way, the base backs off from it. Fails on a fault that a person must clear, and
    when the arm cannot reach the posture.

    Args:
        arm: joint positions to come back to; `ready` is always there. Without it the hand is only
            lifted, and only after a fault.
    """

    key: ClassVar[str] = "recover"
    base_rests: ClassVar[bool] = True
    goes_to: ClassVar[tuple[str, ...]] = ("arm",)

    def __init__(self, name: str, context: Context, *, arm: Posture | None = None) -> None:
        super().__init__(name, context)
        self._arm = arm

    @property
    def phase(self) -> str:
        """`clear` while there are faults, `back off` and `rise` to make room, then `fold`."""
        if self.context.state.faults or self.context.state.recovering:
            return "clear"
        return _PHASES.get(type(self._way), "fold")

    def initialise(self) -> None:
        """Start anew, from wherever the hand is now."""
        self.context.vision.reset()
        self._faults = self._backed_off = 0
        self._is_cleared = False
        self._way: BackOff | Rise | None = None
        self._ways: list[Callable[[], BackOff | Rise]] = []
        if self._arm is not None and not self._folded(self._arm):
            self._ways.append(partial(Rise, self, _RISE))
        self._progress = Progress(self.context, rest=_REST)

    def update(self) -> Status:
        """One tick."""
        context = self.context
        for fault in context.state.faults:
            if not fault.clearable:
                return self.failure(f"{fault.text}: clear it by hand, then run the task again")
        if context.state.recovering:
            return self.running("recovering")
        if fault_text := self.fault():
            return self._clear(fault_text)
        way = context.memory.faults.take_way_out(context.state.oTb)
        if way is not None or self._is_cleared:
            self._leave(way)
        if self._way is None and self._ways:
            self._way = self._ways.pop(0)()
        if self._way is not None:
            doing = "rising" if isinstance(self._way, Rise) else "backing off"
            if self._way.tick():
                self._way, self._progress = None, Progress(context, rest=_REST)
            return self.running(doing)
        if self._arm is None:
            cleared = f"cleared {counted(self._faults, 'fault')}"
            return self.success(cleared if self._faults else "healthy")
        return self._fold(self._arm)

    def _clear(self, fault_text: str) -> Status:
        """Clear the faults once it is time to."""
        memory, now = self.context.memory.faults, self.context.clock.now()
        if memory.given_up:
            return self.running(f"waiting for a person: {memory.given_up}")
        if (wait := memory.wait(now)) > 0.0:
            return self.running(f"clearing in {wait:.1f} s: {fault_text}")
        self._faults += 1
        self._is_cleared = True
        memory.clear(now)
        self.context.robot.recover()
        return self.running(f"clearing: {fault_text}")

    def _leave(self, way: WayOut | None) -> None:
        """Leave a contact: the part that was touched first, the hand before the base."""
        hand, base = (None, None) if way is None else (way.hand, way.base)
        self._is_cleared, self._way = False, None
        self._ways = [partial(Rise, self, _RISE, hand)]
        if base is not None:
            self._ways.insert(hand is not None, partial(BackOff, self, base, AWAY_SPEED))

    def _fold(self, arm: Posture) -> Status:
        report = self.pursue(PostureGoal(q=arm.q), "fold")
        if report is None:
            return self.running(f"folding to {arm.name}")
        if report.arrived:
            return self.success(f"arm {arm.name}")
        remaining = degrees(report.orientation_error)
        if self._progress.is_stuck(report):
            if report.clearance >= IN_THE_WAY or self._backed_off == _MOST_BACK_OFFS:
                return self.failure(f"arm stopped {remaining:.0f}° before {arm.name}")
            self._backed_off += 1
            self._ways.append(partial(BackOff, self))
        return self.running(f"folding to {arm.name}, {remaining:.0f}° to go")

    def _folded(self, arm: Posture) -> bool:
        return bool(np.abs(self.context.state.q - arm.q).max() < _FOLDED)


_PHASES: dict[type, str] = {Rise: "rise", BackOff: "back off"}
