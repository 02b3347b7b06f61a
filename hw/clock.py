"""Time, injected: the only place of the project that knows the computer's own clock."""

from __future__ import annotations

import time
from typing import Protocol


class Clock(Protocol):
    """Where everything else gets its time from."""

    def now(self) -> float:
        """Seconds since the session began [s]."""

    def sleep_until(self, stamp: float) -> None:
        """Return when `now()` is at least `stamp` [s]."""


class SimClock:
    """Simulated time: it jumps where it is told to, paced by the computer's clock on request.

    Args:
        pace: simulated seconds per real second at most; None runs as fast as it can.
    """

    def __init__(self, pace: float | None = None) -> None:
        self._now = 0.0
        self._pace = pace
        self._began: float | None = None

    def now(self) -> float:
        """Simulated seconds since the session began [s]."""
        return self._now

    def sleep_until(self, stamp: float) -> None:
        """Advance to `stamp` [s], never backwards; the pace counts from the first call."""
        if self._began is None:
            self._began = time.monotonic()
        self._now = max(self._now, stamp)
        if self._pace is not None:
            ahead = self._now / self._pace - (time.monotonic() - self._began)
            if ahead > 0.0:
                time.sleep(ahead)


class WallClock:
    """Real, monotonic time since the clock was made."""

    def __init__(self) -> None:
        self._start = time.monotonic()

    def now(self) -> float:
        """Seconds since the session began [s]."""
        return time.monotonic() - self._start

    def sleep_until(self, stamp: float) -> None:
        """Sleep until `stamp` [s]; returns at once when it has passed."""
        ahead = stamp - self.now()
        if ahead > 0.0:
            time.sleep(ahead)


def stopwatch() -> float:
    """Real seconds from an arbitrary start, to measure how long a computation took [s]."""
    return time.perf_counter()
