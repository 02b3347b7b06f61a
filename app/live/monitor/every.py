"""Thins out what comes oftener than anybody looks."""

from __future__ import annotations

_ROUNDING = 1e-6
"""Stamps are sums of periods; one that is this early is on time [s]."""


class Every:
    """Says when it is time again.

    Args:
        period: from one time to the next at least [s].
        start: the first time; at once unless said otherwise [s].
    """

    def __init__(self, period: float, start: float = float("-inf")) -> None:
        self._period = period
        self._next = start

    def due(self, stamp: float) -> bool:
        """Whether it is time at `stamp` [s]; if so, the next time is a period later."""
        if stamp < self._next - _ROUNDING:
            return False
        self._next = stamp + self._period
        return True
