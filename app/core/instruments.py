"""What a bench puts into a run to measure or to disturb it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from hw import Robot

if TYPE_CHECKING:
    from app.core.session import Tick
    from app.core.setup import Setup
    from trees.language import TreeNode


class Instruments:
    """Has a hand in every part of a run; this one keeps its hands off."""

    def beneath(self, robot: Robot) -> Robot:
        """A robot in place of the one that faults are injected into."""
        return robot

    def begin(self, setup: Setup, nodes: Sequence[TreeNode]) -> None:
        """Everything is put together and the robot is connected; nothing has moved."""

    def after(self, tick: Tick) -> None:
        """Called after every tick."""
