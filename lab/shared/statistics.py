"""Shares, means and differences with 95 % confidence intervals."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from config.arrays import Array

_DRAWS = 10_000  # of a bootstrap


def interval(outcomes: Sequence[bool]) -> tuple[float, float]:
    """95 % confidence interval of the share of good outcomes (Wilson, 1927)."""
    from scipy.stats import binomtest

    found = binomtest(int(sum(outcomes)), len(outcomes)).proportion_ci(method="wilson")
    return float(found.low), float(found.high)


def percent(outcomes: Sequence[bool]) -> str:
    """The share of good outcomes and its 95 % interval, for a table; `-` without outcomes."""
    if not outcomes:
        return "-"
    low, high = interval(outcomes)
    part = 100.0 * sum(outcomes) / len(outcomes)
    return f"{part:.1f} ({100.0 * low:.1f} to {100.0 * high:.1f})"


def bootstrap(
    values: Sequence[float], statistic: Callable[..., Any] = np.mean, draws: int = 2000
) -> tuple[float, float]:
    """95 % interval of a statistic of values by seeded bootstrap (Efron, 1979)."""
    sample = np.array(values)
    drawn = np.random.default_rng(0).integers(len(sample), size=(draws, len(sample)))
    low, high = np.percentile(statistic(sample[drawn], axis=1), (2.5, 97.5))
    return float(low), float(high)


def paired_difference(
    one: Array,
    other: Array,
    per: tuple[Array, Array] | None = None,
) -> tuple[float, float, float]:
    """Difference of two means over the same scenes, and its 95 % interval by seeded bootstrap.

    `one` and `other` are (N,) quantities in each scene, `per` the (N,) cost of each, which its sum
    is divided by; None is 1 for each scene.
    """
    n = len(one)
    spent = (np.ones(n), np.ones(n)) if per is None else per
    drawn = np.random.default_rng(0).integers(0, n, (_DRAWS, n))

    def ratio(reached: Array, cost: Array) -> float:
        return float(reached.sum() / max(cost.sum(), 1.0))

    def ratios(reached: Array, cost: Array) -> Array:
        shares: Array = reached[drawn].sum(axis=1) / np.maximum(cost[drawn].sum(axis=1), 1.0)
        return shares

    low, high = np.percentile(ratios(one, spent[0]) - ratios(other, spent[1]), (2.5, 97.5))
    return ratio(one, spent[0]) - ratio(other, spent[1]), float(low), float(high)
