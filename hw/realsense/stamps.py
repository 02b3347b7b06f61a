"""When an image was captured, on the computer's clock.

A camera of the D400 series stamps on the computer's calendar time where its driver has metadata
(`global_time`, `system_time`), else on a clock of its own. The first tells how old an image is. Of
the second only differences are known: the image that took the shortest way so far is taken for one
that arrived at once.
"""

from __future__ import annotations

from collections import deque
from math import inf

_OLDEST = 1.0
"""An image that is said to be older, or to come from the future, has another calendar [s]."""
_FUTURE = 5e-3
"""[s]"""
_REMEMBERED = 300
"""Images over which the shortest way is sought: clocks drift."""


class CameraClock:
    """From stamps of a camera to those of `stopwatch`.

    Args:
        delay: how old an image is at the stamp that the camera gives it [s].
    """

    def __init__(self, delay: float = 0.0) -> None:
        self._delay = delay
        self._offsets: deque[float] = deque(maxlen=_REMEMBERED)
        self._last = -inf

    def stamp(self, told: float, arrived: float, calendar: float | None) -> float:
        """When an image was captured, of `stopwatch` [s].

        Args:
            told: by the camera [s].
            arrived: when the image did, of `stopwatch` [s].
            calendar: the calendar time at that moment [s]; None if the camera has its own clock.
        """
        if calendar is not None and -_FUTURE <= calendar - told <= _OLDEST:
            return arrived - max(calendar - told, 0.0) - self._delay
        if told < self._last:  # a recording has begun again
            self._offsets.clear()
        self._last = told
        self._offsets.append(arrived - told)
        return told + min(self._offsets) - self._delay
