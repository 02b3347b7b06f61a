"""Come back to a known state after anything: clear faults, rise, fold the arm to a posture."""

from __future__ import annotations

from math import degrees
from typing import ClassVar

import numpy as np
from py_trees.common import Status

from behaviours.back_off import BackOff
from behaviours.context import Context
from behaviours.leaf import Leaf
from behaviours.poses import Posture
from behaviours.progress import Progress
from behaviours.ranges import Lift
from behaviours.rise import Rise
from controller import PostureGoal


class Recover(Leaf):
    """Clear what a program may clear, lift the hand out of harm's way, fold the arm.

    With nothing to clear and no posture to come back to it succeeds at once. Where furniture is in
    the arm's way, the base backs off from it. Fails on a fault that a person must clear, on faults
    that come back more than three times, and when the arm cannot reach the posture.

    Args:
        arm: joint positions to come back to; `ready` is always there. Without it the hand is only
            lifted, and only after a fault.
        rise_m: lift the hand this far before the arm folds [m].
    """

    key: ClassVar[str] = "recover"
    goes_to: ClassVar[tuple[str, ...]] = ("arm",)

    def __init__(
        self, name: str, context: Context, *, arm: Posture | None = None, rise_m: Lift = 0.15
    ) -> None:
        super().__init__(name, context)
        self._arm = arm
        self._height = rise_m

    @property
    def phase(self) -> str:
        """`clear` while there are faults, `rise`, then `fold`; `back off` to make room for that."""
        if self.context.state.faults or self.context.state.recovering:
            return "clear"
        if self._behind is not None:
            return "back off"
        return "fold" if self._rise is None else "rise"

    def initialise(self) -> None:
        """Start anew, from wherever the hand is now."""
        self.context.vision.reset()
        self._faults = self._backed_off = 0
        self._behind: BackOff | None = None
        is_to_fold = self._arm is not None and not self._folded(self._arm)
        self._rise = Rise(self, self._height) if is_to_fold else None
        self._progress = Progress(self.context)

    def update(self) -> Status:
        """One tick."""
        context = self.context
        for fault in context.state.faults:
            if not fault.clearable:
                return self.failure(f"{fault.text}: clear it by hand, then run the task again")
        if context.state.recovering:
            return self.running("recovering")
        if fault_text := self.fault():
            self._faults += 1
            self._rise = Rise(self, self._height)
            most = self.settings.recover.most_faults
            if self._faults > most:
                return self.failure(f"cleared {most} times, and again: {fault_text}")
            context.robot.recover()
            return self.running(f"clearing: {fault_text}")
        if self._rise is not None:
            return self._lift(self._rise)
        if self._behind is not None:
            return self._back_off(self._behind)
        if self._arm is None:
            return self.success(f"cleared {self._faults} faults" if self._faults else "healthy")
        return self._fold(self._arm)

    def _lift(self, rise: Rise) -> Status:
        if rise.tick():
            self._rise, self._progress = None, Progress(self.context)
        return self.running("rising")

    def _fold(self, arm: Posture) -> Status:
        report = self.pursue(PostureGoal(q=arm.q), "fold")
        if report is None:
            return self.running(f"folding to {arm.name}")
        if report.arrived:
            return self.success(f"arm {arm.name}")
        left = degrees(report.orientation_error)
        if self._progress.is_stuck(report):
            settings = self.settings.recover
            near = report.clearance < settings.in_the_way
            if not near or self._backed_off == settings.most_back_offs:
                return self.failure(f"arm stopped {left:.0f}° before {arm.name}")
            self._backed_off += 1
            self._behind = BackOff(self)
        return self.running(f"folding to {arm.name}, {left:.0f}° to go")

    def _back_off(self, behind: BackOff) -> Status:
        """Away from what is in the arm's way."""
        if behind.tick():
            self._behind, self._progress = None, Progress(self.context)
        return self.running("backing off")

    def _folded(self, arm: Posture) -> bool:
        return bool(np.abs(self.context.state.q - arm.q).max() < self.settings.recover.folded)
