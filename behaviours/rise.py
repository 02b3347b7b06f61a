"""The hand comes straight up, out from among what stands around it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pinocchio import SE3

from behaviours.context import Context
from behaviours.leaf import Leaf
from behaviours.progress import Progress
from controller import PoseGoal

_NEAR = 0.01
"""The hand is back this near to where it came from [m]."""


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
        back: where the hand goes first, in the world: out of what it has hit.
    """

    def __init__(self, leaf: Leaf, height: float, back: SE3 | None = None) -> None:
        self._leaf = leaf
        self._height = height
        self._is_back = back is None
        self._go(leaf.settings.retreat.recovery_speed, back)

    def tick(self) -> bool:
        """Go on; whether that is over: the hand is up, or gets no further."""
        report = self._leaf.pursue(self._goal, "rise" if self._is_back else "back")
        if report is None:
            return False
        is_there = report.position_error <= self._goal.position_tolerance
        if not (is_there or self._progress.is_stuck(report)):
            return False
        if not self._is_back:
            self._is_back = True
            self._go(self._leaf.settings.retreat.recovery_speed)
            return False
        return True

    def _go(self, speed: float, back: SE3 | None = None) -> None:
        context = self._leaf.context
        self._goal = straight_up(context, self._height, speed)
        if back is not None:
            slow, near = context.settings.recover.away_speed, _NEAR
            self._goal = replace(self._goal, wTe=back, speed=slow, position_tolerance=near)
        self._progress = Progress(context, straight=True)
