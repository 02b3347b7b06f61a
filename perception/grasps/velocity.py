"""How fast what is grasped moves, from where its middle was seen in one frame after another.

A straight line is fitted to the middles of the last moments (least squares). The grasp itself tells
less: it may slide along an object that stands still. So does the middle of what the image cuts off,
which is left out, and so is one that is not on the line; several of these begin a new one.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import hypot, inf

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class VelocitySettings:
    """When a grasp counts as moving."""

    window: float = 0.6
    """What was seen so long before the newest, or longer, tells nothing any more [s]."""
    least_time: float = 0.1
    """Nobody knows how an object moves before its middle was seen for so long [s] ..."""
    least_frames: int = 5
    """... and in this many frames ..."""
    patience: float = 0.2
    """... but that is not waited for longer than this; then it counts as standing still [s]."""
    least_speed: float = 0.05
    """What is slower than this stands still [m/s]."""
    straightness: float = 0.1
    """A motion scatters about its line by at most this share of its length, root mean square."""
    jump: float = 0.02
    """A middle is that of something else if it has come farther than this [m] ..."""
    fastest: float = 0.3
    """... and farther than at this speed [m/s]."""
    astray: float = 0.01
    """Once it is known how an object moves, a middle is none of it that is farther than this from
    where it will have come [m] ..."""
    unsteady: float = 0.03
    """... and farther than if its speed had changed by this [m/s]: the image shows only a part."""
    reach: float = 0.08
    """A grasp no farther than this from where the middle will have come is on that object [m]."""


_DEFAULT = VelocitySettings()


class GraspVelocity:
    """The velocity of one grasp over the floor.

    Args:
        settings: when it counts as moving.
    """

    def __init__(self, settings: VelocitySettings = _DEFAULT) -> None:
        self._settings = settings
        self._seen: deque[tuple[float, float, float]] = deque()
        self._since = inf
        self._velocity = np.zeros(3)
        self._line: tuple[Array, Array] | None = None
        """Fitted last: stamp, x and y of its middle, and its rate."""
        self._astray = 0
        self.is_known = False
        """Whether it was seen for long enough to tell, or to give that up."""

    def __call__(self, middle: tuple[float, float] | None, stamp: float) -> Array:
        """The velocity (3,), level, after one more frame [m/s]; zeros if it stands still.

        Args:
            middle: x, y of the object in the world [m]; None if it is not seen.
            stamp: when the frame was captured [s].
        """
        s, seen = self._settings, self._seen
        self._since = min(self._since, stamp)
        self.is_known = self.is_known or stamp - self._since >= s.patience
        if middle is None or not self.may_be_at(middle, stamp):
            return self._velocity
        if self._is_astray(middle, stamp):
            self._astray += 1
            if self._astray < s.least_frames:
                return self._velocity
            seen.clear()
            self._line = None
        self._astray = 0
        seen.append((stamp, *middle))
        while stamp - seen[0][0] > s.window:
            seen.popleft()
        time = stamp - seen[0][0]
        if len(seen) < s.least_frames or time < s.least_time:
            return self._velocity
        self.is_known = True
        mean = np.mean(seen, axis=0)
        table = np.array(seen) - mean
        times, places = table[:, 0], table[:, 1:]
        rate = times @ places / (times @ times)
        self._line = mean, rate
        speed = np.linalg.norm(rate)
        scatter = np.sqrt(np.mean(np.sum((places - np.outer(times, rate)) ** 2, axis=1)))
        moves = speed >= s.least_speed and scatter <= s.straightness * speed * time
        self._velocity = np.array([*rate, 0.0]) if moves else np.zeros(3)
        return self._velocity

    def may_be_at(self, middle: tuple[float, float], stamp: float) -> bool:
        """Whether the object can have come there since it was seen last."""
        if not self._seen:
            return True
        then, x, y = self._seen[-1]
        s = self._settings
        return hypot(middle[0] - x, middle[1] - y) <= s.jump + s.fastest * (stamp - then)

    def has_brought(self, place: Array, stamp: float) -> bool:
        """Whether what moves has come to where a grasp is on it, whose image shows no middle.

        Args:
            place: (2,) x and y of the grasp in the world [m].
            stamp: when it is seen there [s].
        """
        if self._line is None or not self._velocity.any():
            return False
        return bool(np.linalg.norm(self._expected(stamp) - place) <= self._settings.reach)

    def _expected(self, stamp: float) -> Array:
        """(2,) where the middle will have come by the line [m]."""
        assert self._line is not None
        mean, rate = self._line
        there: Array = mean[1:] + rate * (stamp - mean[0])
        return there

    def _is_astray(self, middle: tuple[float, float], stamp: float) -> bool:
        """Whether it is not where the object will have come."""
        if self._line is None or not self._seen:
            return False
        s, since = self._settings, stamp - self._seen[-1][0]
        away = np.linalg.norm(self._expected(stamp) - middle)
        return bool(away > s.astray + s.unsteady * since)
