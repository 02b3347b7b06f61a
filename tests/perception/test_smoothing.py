"""Noise of far depth is averaged away, and edges and holes stay."""

import numpy as np
import pytest

from perception.grasps.stereo import smoothed

FX, BASELINE = 385.0, 0.05


def step(near: float, far: float, noise: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """The true depth of a step and what a stereo camera measures, with a noise in pixels."""
    true = np.full((60, 80), far, dtype=np.float32)
    true[20:40, 30:50] = near
    disparity = FX * BASELINE / true
    disparity += noise * np.random.default_rng(seed).standard_normal(true.shape)
    return true, (FX * BASELINE / disparity).astype(np.float32)


def test_a_far_surface_is_measured_several_times_better() -> None:
    true, measured = step(1.5, 1.5, noise=0.1)
    before, after = (np.std(depth - true) for depth in (measured, smoothed(measured, FX)))
    assert before == pytest.approx(0.0117, rel=0.1)
    assert after < before / 3


def test_the_edge_of_a_thing_stays_where_it_is() -> None:
    true, measured = step(1.35, 1.5, noise=0.05)
    result = smoothed(measured, FX)
    middle = 0.5 * (1.35 + 1.5)
    assert np.mean((result < middle) == (true < middle)) > 0.999
    assert np.abs(result[20:40, 30:50] - 1.35).mean() < 0.006


def test_a_hole_stays_a_hole_and_spoils_nothing_around_it() -> None:
    true, measured = step(1.5, 1.5, noise=0.02)
    measured[30, 40] = np.nan
    measured[10:14, 10:14] = 0.0
    result = smoothed(measured, FX)
    assert np.isnan(result[30, 40])
    assert np.isnan(result[10:14, 10:14]).all()
    seen = np.isfinite(result)
    assert seen.sum() == true.size - 17
    assert np.abs(result[seen] - 1.5).max() < 0.006
