"""Which postures of the arm are free, the base standing where it is."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from controller.collision import CollisionModel, PairKind
from controller.command import Array

_OF_THE_ARM = (PairKind.SELF, PairKind.ARM, PairKind.HAND, PairKind.PALM, PairKind.ARM_MOVING)
_SLACK = 1e-3
"""A pair that begins nearer than the clearance may come this much nearer still [m]."""


class ArmSpace:
    """The postures of one arm among what stands around it.

    Args:
        collision: the shapes of robot and surroundings.
        wTb: base pose.
        clearance: that the arm keeps [m].
        close: the same where the hand may touch what is around [m].
    """

    def __init__(self, collision: CollisionModel, wTb: SE3, clearance: float, close: float) -> None:
        self._collision = collision
        self._wTb = wTb
        self._clearance = clearance
        self._close = close
        kinds = collision.pairs.kind
        self._pairs = np.flatnonzero(np.isin(kinds, _OF_THE_ARM))
        self._of_the_hand = kinds[self._pairs] == PairKind.HAND

    def test(self, start: Array, goal: Array | None = None, *, hand_may_touch: bool) -> FreeTest:
        """What tells whether a posture is free.

        What begins nearer than the clearance may be as near all the way, or no motion would begin.

        Args:
            start: (7,) where the arm is [rad].
            goal: (7,) where the hand may come as near as it does there [rad].
            hand_may_touch: whether hand and fingers may touch what is around.
        """
        clearance = self._close if hand_may_touch else self._clearance
        margins = np.minimum(clearance, self._distances(start) - _SLACK)
        pairs = self._pairs
        if hand_may_touch and goal is None:
            pairs, margins = pairs[~self._of_the_hand], margins[~self._of_the_hand]
        elif hand_may_touch and goal is not None:
            there = np.minimum(margins, self._distances(goal) - _SLACK)
            margins = np.where(self._of_the_hand, there, margins)
        return FreeTest(self._collision, self._wTb, pairs, margins)

    def _distances(self, q: Array) -> Array:
        """(P,) of the pairs at a posture [m]."""
        self._collision.place(self._wTb, q)
        return np.array(
            [self._collision.measure(pair).min_distance for pair in self._pairs.tolist()]
        )


class FreeTest:
    """Tells whether postures are free.

    Args:
        collision: the shapes.
        wTb: base pose.
        pairs: (P,) numbers of those that count.
        margins: (P,) distances that they keep [m].
    """

    def __init__(
        self,
        collision: CollisionModel,
        wTb: SE3,
        pairs: npt.NDArray[np.int64],
        margins: Array,
    ) -> None:
        self._touches = collision.contact_test(wTb, pairs, margins)

    def __call__(self, q: Array) -> bool:
        """Whether nothing comes too near at q (7,)."""
        return not self._touches(q)

    def all_free(self, path: Array, resolution: float) -> bool:
        """Whether a path of straight pieces through (M, 7) postures is free."""
        for a, b in pairwise(path):
            count = max(1, int(np.ceil(float(np.linalg.norm(b - a)) / resolution)))
            if not all(self(a + (b - a) * step / count) for step in range(1, count + 1)):
                return False
        return True
