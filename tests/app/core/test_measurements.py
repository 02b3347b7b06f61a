"""Measurements of a run."""

import numpy as np

from app.core.measurements import Durations


def test_quantiles_are_within_one_percent_in_bounded_memory():
    values = np.random.default_rng(0).lognormal(-8.0, 1.5, 50_000)
    durations = Durations()
    for value in values:
        durations.append(value)
    assert len(durations) == len(values)
    assert len(durations._counts) < 1000
    for share in (0.01, 0.5, 0.99):
        np.testing.assert_allclose(
            durations.quantile(share), np.quantile(values, share), rtol=0.011
        )
    assert Durations().quantile(0.5) == 0.0
