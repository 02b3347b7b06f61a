"""Behaviour `open_gripper`."""

from typing import ClassVar

from py_trees.common import Status

from behaviours.core.leaf import Leaf


class OpenGripper(Leaf):
    """Open the fingers fully and wait until they are.

    Fails when the robot has a fault or the fingers stop before they are open.
    """

    key: ClassVar[str] = "open_gripper"
    hand_after: ClassVar[str] = "empty"
    moves: ClassVar[bool] = False

    def initialise(self) -> None:
        """Start to open, unless the fingers are open already."""
        if not self.gripper_is_open:
            self.let_go()

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
