"""Base or hand come a little way back from where they are."""

from __future__ import annotations

import numpy as np
from pinocchio import SE3

from behaviours.leaf import Leaf
from behaviours.progress import Progress
from controller import BaseGoal, PoseGoal


class BackOff:
    """The base drives backwards, as far as there is room.

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


class Withdrawal:
    """The hand comes back towards the base, level: what goes down there next hits nothing.

    Args:
        leaf: whose way it is.
    """

    def __init__(self, leaf: Leaf) -> None:
        self._leaf = leaf
        self._goal: PoseGoal | None = None
        self._progress = Progress(leaf.context, straight=True)

    def tick(self) -> bool:
        """Go on, from where the hand is at the first tick; whether that is over."""
        context, settings = self._leaf.context, self._leaf.settings.retreat
        if self._goal is None:
            away = context.wTe.translation - context.state.wTb.translation
            away[2] = 0.0
            back = settings.withdraw / max(float(np.linalg.norm(away)), settings.withdraw) * away
            self._goal = PoseGoal(
                wTe=SE3(context.wTe.rotation, context.wTe.translation - back),
                speed=settings.speed,
                position_tolerance=settings.tolerance,
                straight=True,
                hand_may_touch=True,
            )
            self._progress = Progress(context, straight=True)
        report = self._leaf.pursue(self._goal, "withdraw")
        return report is not None and (report.arrived or self._progress.is_stuck(report))
