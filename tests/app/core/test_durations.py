"""Quantiles in bounded memory are as good as those of all values."""

import numpy as np

from app.core.durations import Durations


def test_quantiles_are_within_one_percent():
    values = np.random.default_rng(0).lognormal(-8.0, 1.5, 50_000)
    durations = Durations()
    for value in values:
        durations.append(value)
    assert len(durations) == len(values)
    for share in (0.01, 0.5, 0.99):
        np.testing.assert_allclose(
            durations.quantile(share), np.quantile(values, share), rtol=0.011
        )


def test_memory_does_not_grow_with_the_number():
    durations = Durations()
    for number in range(100_000):
        durations.append(1e-4 * (1 + number % 1000))
    assert len(durations._counts) < 500


def test_nothing_took_no_time():
    assert Durations().quantile(0.5) == 0.0
