"""How long something took, many times: quantiles in bounded memory."""

from __future__ import annotations

from collections import Counter
from math import exp, log

_STEP = 0.0199
"""Ratio of neighbouring bins, as its logarithm: half of it is less than 1 %."""
_SMALLEST = 1e-9
"""Shorter than this counts as this [s]."""


class Durations:
    """A histogram on a logarithmic scale: a quantile is off by less than 1 %."""

    def __init__(self) -> None:
        self._counts: Counter[int] = Counter()

    def __len__(self) -> int:
        return self._counts.total()

    def append(self, seconds: float) -> None:
        """Count one more."""
        self._counts[round(log(max(seconds, _SMALLEST)) / _STEP)] += 1

    def quantile(self, share: float) -> float:
        """What this share of them, from 0 to 1, does not exceed [s]; 0 if there is none."""
        left = share * len(self)
        for step in sorted(self._counts):
            left -= self._counts[step]
            if left <= 0:
                return exp(_STEP * step)
        return 0.0
