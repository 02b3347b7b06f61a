"""The base comes a little way back from what it or the arm is near."""

from __future__ import annotations

import numpy as np
from pinocchio import SE3

from behaviours.leaf import Leaf
from behaviours.progress import Progress
from controller import BaseGoal


class BackOff:
    """Backwards, as far as there is room, the arm as it is.

    Args:
        leaf: whose way it is.
    """

    def __init__(self, leaf: Leaf) -> None:
        self._leaf = leaf
        back = SE3(np.eye(3), np.array([-leaf.settings.recover.back_off, 0.0, 0.0]))
        self._goal = BaseGoal(wTb=leaf.context.state.wTb * back, reverse=True)
        self._progress = Progress(leaf.context)

    def tick(self) -> bool:
        """Go on; whether that is over."""
        report = self._leaf.pursue(self._goal, "back off")
        return report is not None and (report.arrived or self._progress.is_stuck(report))
