"""The shape of what the hand holds, as far as the fingers and the last grasp tell."""

from __future__ import annotations

import numpy as np
from pinocchio import SE3

from behaviours.log import Carried, TaskLog
from robots import Box, Geom

_LEAST_HALF = 0.14
"""What is held may reach this far along the pads, which nothing measures: 16 cm, gripped near its
end [m]."""
_ABOVE = 0.02
"""And this far above the grasp centre [m]."""
_COARSE = 0.005
"""Widths that differ by less than this are the same shape [m]."""


class Held:
    """Keeps the shape as long as it is the same one.

    Args:
        log: of the task.
    """

    def __init__(self, log: TaskLog) -> None:
        self._log = log
        self._shape: tuple[Geom, ...] = ()
        self._of: tuple[Carried, float] | None = None

    def shape(self, width: float) -> tuple[Geom, ...]:
        """In e; nothing for an empty hand.

        Args:
            width: distance between the finger pads [m].
        """
        carried = self._log.in_hand
        if carried is None:
            self._of, self._shape = None, ()
            return self._shape
        of = (carried, round(width / _COARSE) * _COARSE)
        if of != self._of:
            self._of, self._shape = of, (_box(width, self._log.grip_height),)
        return self._shape


def _box(width: float, height: float) -> Geom:
    """From above the grasp centre down to what the object stood on."""
    below = max(height, 0.0)
    half = (max(_LEAST_HALF, width / 2.0), width / 2.0, (below + _ABOVE) / 2.0)
    centre = np.array([0.0, 0.0, (below - _ABOVE) / 2.0])
    return Geom(Box(half), SE3(np.eye(3), centre), "held")
