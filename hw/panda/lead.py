"""Velocities ahead of those commanded, for joints that follow late."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hw.panda.streaming import FRESH
from hw.state import Array

_SHORTEST = 0.01
"""Commands that come closer together than this count as so far apart: their slope is noise [s]."""


class Lead:
    """Commands a velocity that joints reach late as if it were that of a moment later.

    Joints of a lag T do r where they are commanded r + T dr/dt. The slope is that of the last two
    commands. A command to rest, and one after a pause, is left as it is.

    Args:
        seconds: by which joints are late; 0 changes nothing.
        qdd: (7,) largest slopes that count [rad/s^2].
    """

    def __init__(self, seconds: float, qdd: Sequence[float]) -> None:
        self._seconds, self._qdd = seconds, np.array(qdd)
        self._last: Array = np.zeros(7)
        self._at = -np.inf

    def of(self, qd: Array, now: float) -> Array:
        """What to command instead of (7,) velocities [rad/s] at a moment [s]."""
        before, gap = self._last, now - self._at
        self._last, self._at = qd, now
        if not self._seconds or gap > FRESH or not qd.any():
            return qd
        slope = (qd - before) / max(gap, _SHORTEST)
        return qd + self._seconds * np.clip(slope, -self._qdd, self._qdd)
