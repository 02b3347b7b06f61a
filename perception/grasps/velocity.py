"""Velocity of a grasped object, from the positions of its middle in successive frames.

A straight line is fitted to the middles of the last moments (least squares). The grasp itself tells
less: it may slide along an object that stands still. The middle of an object that the image cuts
off is left out, and so is one that is not on the line; several of these begin a new one.
"""

from __future__ import annotations

from collections import deque
from math import hypot, inf

import numpy as np

from perception.frame import Array

_WINDOW = 0.6  # of the fit [s]
_LEAST_TIME, _LEAST_FRAMES = 0.1, 5  # of observation until the velocity is known [s] ...
_PATIENCE = 0.2  # ... or until it counts as standing still [s]
_LEAST_SPEED = 0.05  # slower objects stand still [m/s]
_STRAIGHTNESS = 0.1  # largest rms scatter about the line, as a share of its length
_JUMP = 0.02  # a middle is that of another object if it came farther than this [m] ...
_FASTEST = 0.3  # ... and farther than at this speed [m/s]
_ASTRAY = 0.01  # largest distance of a middle from the line [m] ...
_UNSTEADY = 0.03  # ... plus this change of speed: the image shows only a part [m/s]
_REACH = 0.08  # largest distance of a grasp on the object from its middle [m]


class GraspVelocity:
    """The horizontal velocity of one grasp."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, float, float]] = deque()
        self._since = inf
        self._velocity = np.zeros(3)
        self._line: tuple[Array, Array] | None = None  # mean of (stamp, x, y), and rate
        self._astray = 0
        self.is_known = False  # whether it was seen for long enough

    def __call__(self, middle: tuple[float, float] | None, stamp: float) -> Array:
        """Velocity (3,) after one more frame [m/s]; zeros if it stands still.

        Args:
            middle: x, y of the object in the world [m]; None if it is not seen.
            stamp: time of capture [s].
        """
        seen = self._seen
        self._since = min(self._since, stamp)
        self.is_known = self.is_known or stamp - self._since >= _PATIENCE
        if middle is None or not self.may_be_at(middle, stamp):
            return self._velocity
        if self._is_astray(middle, stamp):
            self._astray += 1
            if self._astray < _LEAST_FRAMES:
                return self._velocity
            seen.clear()
            self._line = None
        self._astray = 0
        seen.append((stamp, *middle))
        while stamp - seen[0][0] > _WINDOW:
            seen.popleft()
        time = stamp - seen[0][0]
        if len(seen) < _LEAST_FRAMES or time < _LEAST_TIME:
            return self._velocity
        self.is_known = True
        mean = np.mean(seen, axis=0)
        table = np.array(seen) - mean
        times, places = table[:, 0], table[:, 1:]
        rate = times @ places / (times @ times)
        self._line = mean, rate
        speed = np.linalg.norm(rate)
        scatter = np.sqrt(np.mean(np.sum((places - np.outer(times, rate)) ** 2, axis=1)))
        moves = speed >= _LEAST_SPEED and scatter <= _STRAIGHTNESS * speed * time
        self._velocity = np.array([*rate, 0.0]) if moves else np.zeros(3)
        return self._velocity

    def may_be_at(self, middle: tuple[float, float], stamp: float) -> bool:
        """Whether the object can have come there since it was seen last."""
        if not self._seen:
            return True
        then, x, y = self._seen[-1]
        return hypot(middle[0] - x, middle[1] - y) <= _JUMP + _FASTEST * (stamp - then)

    def has_reached(self, place: Array, stamp: float) -> bool:
        """Whether the moving object has come to a grasp at (2,) x, y without a visible middle."""
        if self._line is None or not self._velocity.any():
            return False
        return bool(np.linalg.norm(self._expected(stamp) - place) <= _REACH)

    def _expected(self, stamp: float) -> Array:
        """(2,) the middle by the line [m]."""
        assert self._line is not None
        mean, rate = self._line
        there: Array = mean[1:] + rate * (stamp - mean[0])
        return there

    def _is_astray(self, middle: tuple[float, float], stamp: float) -> bool:
        """Whether a middle is too far from the line."""
        if self._line is None or not self._seen:
            return False
        since = stamp - self._seen[-1][0]
        away = np.linalg.norm(self._expected(stamp) - middle)
        return bool(away > _ASTRAY + _UNSTEADY * since)
