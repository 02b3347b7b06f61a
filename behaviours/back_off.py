"""The base comes a little way back from what it or the arm is near."""

from __future__ import annotations

from math import inf

import numpy as np
from pinocchio import SE3

from behaviours.leaf import Leaf
from behaviours.progress import Progress
from controller import Array, BaseGoal

BACKWARDS = np.array([-1.0, 0.0])


class BackOff:
    """As far as there is room, the arm as it is.

    Args:
        leaf: whose way it is.
        away: (2,) unit vector in the base frame: where to.
        speed: largest speed [m/s].
    """

    def __init__(self, leaf: Leaf, away: Array = BACKWARDS, speed: float = inf) -> None:
        self._leaf = leaf
        way = SE3(np.eye(3), np.array([*(leaf.settings.recover.back_off * away), 0.0]))
        wTb = leaf.context.state.wTb * way
        self._goal = BaseGoal(wTb=wTb, reverse=bool(away[0] < 0.0), speed=speed)
        self._progress = Progress(leaf.context)

    def tick(self) -> bool:
        """Go on; whether that is over."""
        report = self._leaf.pursue(self._goal, "back off")
        return report is not None and (report.arrived or self._progress.is_stuck(report))
