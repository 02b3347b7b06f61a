"""Measurements of a run: durations, and the resources of the process."""

import numpy as np

from app.core.measurements import Durations, footprint


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


def test_memory_threads_and_handles_are_counted(tmp_path) -> None:
    with (tmp_path / "open").open("w"):
        found = footprint()
    assert found.rss > 10e6
    assert found.threads >= 1
    assert found.handles > 3
