"""Limits how often something happens, by stamps."""

from __future__ import annotations

_ROUNDING = 1e-6
"""Stamps are sums of periods; one that is this early is on time [s]."""


class Throttle:
    """Lets one of many stamps through per period.

    Args:
        period: shortest time between two that pass [s].
        start: earliest stamp that passes [s]; the default lets the first one through.
    """

    def __init__(self, period: float, start: float = float("-inf")) -> None:
        self._period = period
        self._next = start

    def due(self, stamp: float) -> bool:
        """Whether `stamp` [s] passes; if it does, the next period begins."""
        if stamp < self._next - _ROUNDING:
            return False
        self._next = stamp + self._period
        return True
