"""When an image was captured, on the computer's clock, whatever the camera's clock does.

A camera of the D400 series stamps on the computer's calendar time where its driver has metadata
(`global_time`), else on a clock of its own. The first tells how old an image is. Of the second only
differences are known: the image that took the shortest way so far is taken for one that arrived at
once. Either clock is reported to jump. An image whose stamp cannot be true is stamped by its
arrival, less the usual time on its way.
"""

from __future__ import annotations

from collections import deque
from math import inf
from statistics import median

_OLDEST = 1.0
"""An image that is said to be older has another calendar, or a clock that has jumped [s]."""
_AT_ONCE = 5e-3
"""Where clocks are the same, no image takes less than nothing; they differ by less [s]."""
_ON_ITS_WAY = 20e-3
"""Where all images took longer, one that arrives at once is stamped with its arrival [s]."""
_SOONER = 0.1
"""No image comes sooner than the quickest so far by more than this [s]."""
_USUAL = 20e-3
"""A clock that went back is right again when images take as long as usual, within this [s]."""
_A_FEW, _SETTLED = 5, 30
"""Images after which it is known roughly, and well, how long they take."""
_REMEMBERED = 300
"""Images over which the shortest way is sought: clocks drift."""
_TAKEN_OVER = 3.0
"""What a clock says for longer than this is believed: it was set [s]."""


class CameraClock:
    """From stamps of a camera to those of `stopwatch`.

    Args:
        delay: how old an image is at the stamp that the camera gives it [s].
    """

    def __init__(self, delay: float = 0.0) -> None:
        self._delay = delay
        self._ways: deque[float] = deque(maxlen=_REMEMBERED)
        """From the stamp to the arrival, of images whose stamps were believed [s]."""
        self._least = 0.0
        """What the quickest of them took, as far as a clock has told [s]."""
        self._told = self._believed = -inf
        self._is_back = False

    def stamp(self, told: float, arrived: float, calendar: float | None) -> float:
        """When an image was captured, of `stopwatch` [s].

        Args:
            told: by the camera [s].
            arrived: when the image did, of `stopwatch` [s].
            calendar: the calendar time at that moment [s]; None if the camera has its own clock.
        """
        way = (arrived if calendar is None else calendar) - told
        self._is_back |= told < self._told
        self._told = told
        is_settled = len(self._ways) >= _SETTLED
        if not self._is_believed(way, calendar is not None):
            is_set = arrived - self._believed > _TAKEN_OVER and abs(way) > _AT_ONCE
            is_known = is_settled or (self._is_back and len(self._ways) >= _A_FEW)
            if is_known and not is_set:
                return self._captured(arrived, median(self._ways), calendar)
            self._least = min(self._ways) if is_settled and self._knows_age() else self._least
            self._ways.clear()
            self._is_back = False
        self._believed = arrived
        self._ways.append(way)
        return self._captured(arrived, way, calendar)

    def _is_believed(self, way: float, has_calendar: bool) -> bool:
        """Whether an image can have taken so long [s]."""
        if not self._ways:
            return True
        shortest, usual = min(self._ways), median(self._ways)
        self._is_back &= way > usual + _USUAL
        least = shortest - _SOONER
        if has_calendar and self._knows_age():
            least = _AT_ONCE if shortest > _ON_ITS_WAY else -_AT_ONCE
        return least <= way <= usual + _OLDEST and not self._is_back

    def _knows_age(self) -> bool:
        """Whether stamps of a calendar are of ours."""
        return -_AT_ONCE <= min(self._ways) <= _OLDEST

    def _captured(self, arrived: float, way: float, calendar: float | None) -> float:
        is_age = calendar is not None and self._knows_age()
        age = way if is_age else way - min(self._ways) + self._least
        return arrived - max(age, 0.0) - self._delay
