"""Behaviour `retreat_check`: rise, and check that the hand holds an object."""

from typing import ClassVar

from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.leaf import FINGER_PATIENCE, Leaf
from behaviours.core.motion import Progress, straight_out
from behaviours.core.parameter_types import Lift, ToolPose
from hw import TaskTime

_SPEED = 0.5  # of the rising hand [m/s]


class RetreatCheck(Leaf):
    """Rise, and check that the hand holds something.

    It goes back the way it came. It holds something if the fingers have moved since they were told
    to close, stopped between closed and as far apart as they were before, and rest where they
    stopped. Fails otherwise and when the arm has a fault (Haviland 2022, section V), so that the
    tree tries again. Fingers that still close on the way up hold nothing: they are waited for. A
    grasp that failed is remembered and not chosen again while there are others.

    Args:
        rise_m: how far the hand goes [m].
        next_goal: where the task goes next; the base sets out for it meanwhile.
    """

    key: ClassVar[str] = "retreat_check"
    hand_before: ClassVar[str] = "full"
    hand_after: ClassVar[str] = "full"

    def __init__(
        self, name: str, context: Context, *, rise_m: Lift = 0.2, next_goal: ToolPose | None = None
    ) -> None:
        super().__init__(name, context)
        self._rise = rise_m
        self._next = next_goal

    def initialise(self) -> None:
        """Rise from wherever the hand is now."""
        self._goal = straight_out(
            self.context, self._rise, _SPEED, getattr(self._next, "oTe", None)
        )
        self._progress = Progress(self.context, straight=True)
        self._up_since: TaskTime | None = None

    def update(self) -> Status:
        """One tick."""
        context, now = self.context, self.context.clock.now()
        if fault := self.fault():
            return self._missed(fault)
        if context.log.closing is None:
            return self.failure("the fingers were not told to close")
        fingers, moving = context.log.fingers, context.state.gripper_moving
        width = 1000 * fingers.width
        if (not moving or self.gripper_is_closed) and (reason := self.empty_hand):
            return self._missed(reason)
        report = self.pursue(self._goal)
        if report is None:
            return self.running("rising")
        if report.position_error > self._goal.position_tolerance:
            if self._progress.is_stuck(report):
                below = f"stuck {report.position_error:.2f} m below the retreat"
                return self._missed(below + self._progress.because)
            return self.running(f"rising, {width:.0f} mm between the fingers")
        if fingers.rest:
            context.vision.tracker.forget()
            return self.success(f"holding something {width:.0f} mm wide")
        self._up_since = self._up_since or now
        if now - self._up_since > FINGER_PATIENCE:
            return self._missed(f"the fingers still move after {FINGER_PATIENCE:g} s")
        return self.running("the fingers are slipping off")

    def _missed(self, reason: str) -> Status:
        if self.context.log.last_grasp is not None:
            self.context.vision.tracker.reject(self.context.log.last_grasp)
        return self.failure(reason)
