"""Stand still for a while."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from behaviours.context import Context
from behaviours.leaf import Leaf
from behaviours.ranges import Pause


class Wait(Leaf):
    """Stand still for a while.

    Args:
        duration_s: how long [s].
    """

    key: ClassVar[str] = "wait"
    needs_robot: ClassVar[bool] = False
    lasts: ClassVar[str] = "duration_s"
    moves: ClassVar[bool] = False

    def __init__(self, name: str, context: Context, *, duration_s: Pause) -> None:
        super().__init__(name, context)
        self._duration = duration_s

    def initialise(self) -> None:
        """Start the time."""
        self._begun = self.context.clock.now()

    def update(self) -> Status:
        """One tick."""
        left = self._duration - (self.context.clock.now() - self._begun)
        return self.success("waited") if left <= 0.0 else self.running(f"{left:.1f} s left")
