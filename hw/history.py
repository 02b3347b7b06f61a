"""The last readings of one part, to ask where it was at a moment in between."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable
from typing import Generic, Protocol, TypeVar


class Stamped(Protocol):
    """Anything measured at a known time."""

    @property
    def stamp(self) -> float:
        """When it was measured, on the session's clock [s]."""


Reading = TypeVar("Reading", bound=Stamped)


class History(Generic[Reading]):
    """Readings of the last moments, oldest first.

    Args:
        interpolate: (earlier, later, stamp between theirs [s]) to the reading at that stamp.
        duration: how far back it reaches [s].
    """

    def __init__(
        self, interpolate: Callable[[Reading, Reading, float], Reading], duration: float = 0.5
    ) -> None:
        self._interpolate = interpolate
        self._duration = duration
        self._readings: list[Reading] = []

    def add(self, reading: Reading) -> None:
        """Keep a reading; one of an older or equal stamp takes the place of those after it."""
        readings = self._readings
        while readings and readings[-1].stamp >= reading.stamp:
            readings.pop()
        readings.append(reading)
        while readings[0].stamp < reading.stamp - self._duration:
            readings.pop(0)

    def at(self, stamp: float) -> Reading:
        """The reading at a stamp [s], interpolated; outside of the history the nearest one."""
        index = bisect_left(self._readings, stamp, key=lambda reading: reading.stamp)
        if index == len(self._readings):
            return self._readings[-1]
        later = self._readings[index]
        if index == 0 or later.stamp == stamp:
            return later
        return self._interpolate(self._readings[index - 1], later, stamp)
