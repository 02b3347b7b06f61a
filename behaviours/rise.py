"""The hand comes straight up, out from among what stands around it."""

from __future__ import annotations

import numpy as np
from pinocchio import SE3

from behaviours.context import Context
from behaviours.leaf import Leaf
from behaviours.progress import Progress
from controller import PoseGoal


def straight_up(
    context: Context, height: float, speed: float, onward: SE3 | None = None
) -> PoseGoal:
    """The goal of a hand that rises from wherever it is.

    Args:
        context: what all leaves share.
        height: how far to lift the hand [m].
        speed: of the hand [m/s].
        onward: where the end effector goes next, in the world; the base sets out for it meanwhile.
    """
    here = context.wTe
    return PoseGoal(
        wTe=SE3(here.rotation, here.translation + np.array([0.0, 0.0, height])),
        speed=speed,
        position_tolerance=context.settings.retreat.tolerance,
        straight=True,
        hand_may_touch=True,
        onward=onward,
    )


class Rise:
    """The hand's way up from wherever it is, slowly, as something may be in the way.

    Args:
        leaf: whose way it is.
        height: how far to lift the hand [m].
    """

    def __init__(self, leaf: Leaf, height: float) -> None:
        self._leaf = leaf
        speed = leaf.settings.retreat.recovery_speed
        self._goal = straight_up(leaf.context, height, speed)
        self._progress = Progress(leaf.context, straight=True)

    def tick(self) -> bool:
        """Go on; whether that is over: the hand is up, or gets no further."""
        report = self._leaf.pursue(self._goal, "rise")
        if report is None:
            return False
        is_up = report.position_error <= self._goal.position_tolerance
        return is_up or self._progress.is_stuck(report)
