"""Opening the hand, and whether it holds something."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from behaviours.leaf import Condition, Leaf


class OpenGripper(Leaf):
    """Open the fingers fully and wait until they are.

    Fails when the robot has a fault or the fingers stop before they are open.
    """

    key: ClassVar[str] = "open_gripper"
    moves: ClassVar[bool] = False

    def initialise(self) -> None:
        """Start to open, unless the fingers are open already."""
        if not self.gripper_is_open:
            self.open_gripper()

    def update(self) -> Status:
        """One tick."""
        if fault := self.fault():
            return self.failure(fault)
        state = self.context.state
        if self.gripper_is_open:
            return self.success("open")
        if (waiting := self.fingers("opening")) is not None:
            return waiting
        return self.failure(f"the fingers stopped at {1000 * state.gripper_width:.0f} mm")


class HoldingObject(Condition):
    """Succeeds if the fingers rest on something.

    They do if they have moved when they were told to close, and something stopped them before they
    were closed.
    """

    key: ClassVar[str] = "holding_object"

    def update(self) -> Status:
        """One tick."""
        state = self.context.state
        width = f"{1000 * state.gripper_width:.0f} mm between the fingers"
        reason = "the fingers still move" if state.gripper_moving else self.empty_hand
        if reason is None:
            return self.success(width)
        return self.failure(f"nothing held, {width}: {reason}")
