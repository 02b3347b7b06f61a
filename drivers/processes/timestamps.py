"""Capture times of images on the computer's clock, robust to jumps of the camera's clock.

A camera of the D400 series stamps with the computer's calendar time where its driver has metadata
(`global_time`), else with a clock of its own. Calendar stamps give the age of an image. Of the own
clock only differences are known: the image with the shortest latency so far is assumed to have
arrived at once. An image with an implausible stamp is stamped with its arrival less the median
latency.
"""

from collections import deque
from math import inf
from statistics import median

_OLDEST = 1.0  # largest plausible latency; beyond, calendars differ or a clock has jumped [s]
_AT_ONCE = 5e-3  # tolerance of latencies around zero where the clocks are the same [s]
_DELAYED = 20e-3  # where all latencies are longer, zero is a stamp on arrival [s]
_SOONER = 0.1  # no latency is shorter than the shortest so far by more than this [s]
_USUAL = 20e-3  # a clock that went back is right again within this of the median [s]
_A_FEW, _SETTLED = 5, 30  # numbers of images after which latencies are known roughly, and well
_REMEMBERED = 300  # number of images over which the shortest latency is sought: clocks drift
_TAKEN_OVER = 3.0  # a clock that differs for longer than this was set, and is accepted [s]


class SensorClock:
    """From stamps of a camera to those of `stopwatch`; images are `delay` [s] older."""

    def __init__(self, delay: float = 0.0) -> None:
        self._delay = delay
        self._latencies: deque[float] = deque(maxlen=_REMEMBERED)  # of accepted stamps [s]
        self._least = 0.0  # latency of the quickest image, as far as known [s]
        self._last = self._accepted = -inf
        self._is_back = False

    def stamp(self, given: float, arrived: float, calendar: float | None) -> float:
        """Capture time of an image, of `stopwatch` [s], from its stamp and arrival [s].

        `calendar` is the calendar time at its arrival; None if the camera has its own
        clock.
        """
        latency = (arrived if calendar is None else calendar) - given
        self._is_back |= given < self._last
        self._last = given
        is_settled = len(self._latencies) >= _SETTLED
        if not self._is_plausible(latency, calendar is not None):
            is_set = arrived - self._accepted > _TAKEN_OVER and abs(latency) > _AT_ONCE
            is_known = is_settled or (self._is_back and len(self._latencies) >= _A_FEW)
            if is_known and not is_set:
                return self._captured(arrived, median(self._latencies), calendar)
            self._least = min(self._latencies) if is_settled and self._knows_age() else self._least
            self._latencies.clear()
            self._is_back = False
        self._accepted = arrived
        self._latencies.append(latency)
        return self._captured(arrived, latency, calendar)

    def _is_plausible(self, latency: float, has_calendar: bool) -> bool:
        if not self._latencies:
            return True
        shortest, usual = min(self._latencies), median(self._latencies)
        self._is_back &= latency > usual + _USUAL
        least = shortest - _SOONER
        if has_calendar and self._knows_age():
            least = _AT_ONCE if shortest > _DELAYED else -_AT_ONCE
        return least <= latency <= usual + _OLDEST and not self._is_back

    def _knows_age(self) -> bool:
        """Whether calendar stamps are those of this computer's calendar."""
        return -_AT_ONCE <= min(self._latencies) <= _OLDEST

    def _captured(self, arrived: float, latency: float, calendar: float | None) -> float:
        is_age = calendar is not None and self._knows_age()
        age = latency if is_age else latency - min(self._latencies) + self._least
        return arrived - max(age, 0.0) - self._delay
