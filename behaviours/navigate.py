"""Go somewhere: base and arm as one to a tool pose, or the base alone to a place on the floor."""

from __future__ import annotations

from math import degrees
from typing import ClassVar

from py_trees.common import Status

from behaviours.context import Context
from behaviours.leaf import Leaf, Progress, remaining
from behaviours.names import BasePose, ToolPose
from controller import BaseGoal, MotionGoal, PoseGoal

_PATIENCE = 5.0
"""A base that turns round first brings the hand no nearer for a while [s]."""


class Navigate(Leaf):
    """Move the end effector, or the base, to a named pose.

    Fails when the robot has a fault, no longer comes nearer, or the time is over.

    Args:
        to: a pose of the task file; a tool pose moves base and arm as one, a base pose the base.
        speed_m_s: largest speed of the end effector [m/s].
        timeout_s: give up after this [s].
    """

    key: ClassVar[str] = "navigate"

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        to: ToolPose | BasePose,
        speed_m_s: float = 1.0,
        timeout_s: float = 60.0,
    ) -> None:
        super().__init__(name, context)
        self._to = to
        self._timeout = timeout_s
        self._goal: MotionGoal = (
            PoseGoal(wTe=to.wTe, speed=speed_m_s)
            if isinstance(to, ToolPose)
            else BaseGoal(wTb=to.wTb)
        )

    def initialise(self) -> None:
        """Start anew."""
        self._begun = self.context.clock.now()
        self._progress = Progress(patience=_PATIENCE)

    def update(self) -> Status:
        """One tick."""
        if fault := self.fault():
            return self.failure(fault)
        report, now = self.pursue(self._goal), self.context.clock.now()
        if report is None:
            return self.running(f"setting out for {self._to.name}")
        if report.arrived:
            return self.success(f"at {self._to.name}")
        left = f"{report.position_error:.2f} m, {degrees(report.orientation_error):.0f}° to go"
        if now - self._begun > self._timeout:
            return self.failure(f"not at {self._to.name} after {self._timeout:g} s: {left}")
        if self._progress.stalled(remaining(report), now):
            return self.failure(f"stuck on the way to {self._to.name}: {left}")
        return self.running(left)
