"""Going to one fixed goal, and noticing when that does not work: what all moving leaves share."""

from __future__ import annotations

from math import degrees

from py_trees.common import Status

from behaviours.leaf import Leaf
from behaviours.progress import Progress
from controller import MotionGoal, PostureGoal, StepReport


class Approach:
    """One way to a goal.

    Args:
        leaf: whose way it is; it says how far it has come.
        goal: where to go.
        target: what people call that.
        timeout: give up after this [s].
    """

    def __init__(self, leaf: Leaf, goal: MotionGoal, target: str, timeout: float) -> None:
        self._leaf = leaf
        self._goal = goal
        self._target = target
        self._timeout = timeout
        self._begun = leaf.context.clock.now()
        self._progress = Progress(leaf.context)
        self._set_out = False
        self.is_blocked = False
        """Whether it has ended because the robot came no nearer, beside something."""

    def tick(self) -> Status:
        """Go on; SUCCESS at the goal, FAILURE on a fault, when stuck and when time is over."""
        leaf = self._leaf
        if fault := leaf.fault():
            return leaf.failure(fault)
        if leaf.context.lost:
            return leaf.failure(f"{leaf.context.relocalised}: it is not certain where it is")
        report, now = leaf.pursue(self._goal, self._target), leaf.context.clock.now()
        if report is None or not self._set_out:  # then it is about some other goal
            self._set_out = True
            return leaf.running(f"setting out for {self._target}")
        if report.arrived:
            return leaf.success(f"at {self._target}")
        if report.unreachable:
            leaf.out_of_reach = True
            return leaf.failure(f"cannot get to {self._target}: {report.unreachable}")
        left = self._left(report)
        if now - self._begun > self._timeout:
            return leaf.failure(f"not at {self._target} after {self._timeout:g} s: {left}")
        if self._progress.is_stuck(report):
            self.is_blocked = report.clearance < leaf.settings.recover.in_the_way
            return leaf.failure(f"stuck on the way to {self._target}: {left}")
        return leaf.running(left)

    def _left(self, report: StepReport) -> str:
        angle = f"{degrees(report.orientation_error):.0f}° to go"
        if isinstance(self._goal, PostureGoal):
            return angle
        return f"{report.position_error:.2f} m, {angle}"
