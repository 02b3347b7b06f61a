"""Behaviour `wait`."""

from typing import ClassVar

from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.leaf import Leaf
from behaviours.core.parameter_types import Duration


class Wait(Leaf):
    """Stand still for a while.

    Args:
        duration_s: how long [s].
    """

    key: ClassVar[str] = "wait"
    can_fail: ClassVar[bool] = False
    lasts: ClassVar[str] = "duration_s"
    needs_robot: ClassVar[bool] = False
    moves: ClassVar[bool] = False

    def __init__(self, name: str, context: Context, *, duration_s: Duration) -> None:
        super().__init__(name, context)
        self._duration = duration_s

    def initialise(self) -> None:
        """Start the time."""
        self._begun = self.context.clock.now()

    def update(self) -> Status:
        """One tick."""
        remaining = self._duration - (self.context.clock.now() - self._begun)
        if remaining <= 0.0:
            return self.success("waited")
        return self.running(f"{remaining:.1f} s left")
