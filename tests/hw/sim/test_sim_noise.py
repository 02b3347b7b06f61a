"""Depth noise: its size, and where depth is missing."""

from dataclasses import replace

import numpy as np
import pytest

from hw.sim import D435Noise
from robots import Intrinsics, load_robot

INTRINSICS = Intrinsics(width=320, height=240, fx=383.0, fy=383.0, cx=159.5, cy=119.5)
CAMERA = replace(load_robot("frankie").camera, intrinsics=INTRINSICS)


def flat(depth: float) -> np.ndarray:
    return np.full((INTRINSICS.height, INTRINSICS.width), depth, dtype=np.float32)


def noisy(depth: np.ndarray, seed: int = 0, **settings: float) -> np.ndarray:
    return D435Noise(**settings).apply(depth, CAMERA, np.random.default_rng(seed))


@pytest.mark.parametrize("distance", [0.3, 0.6, 1.2])
def test_the_error_grows_with_the_square_of_the_distance(distance):
    error = noisy(flat(distance)) - distance
    step = 1.0 / 32.0
    disparity = np.sqrt(0.08**2 + step**2 / 12.0)
    expected = disparity * distance**2 / (INTRINSICS.fx * 0.05)
    assert np.nanstd(error) == pytest.approx(expected, rel=0.15, abs=1e-4)
    assert abs(np.nanmean(error)) < 0.08 * expected + 1.5e-4


def test_nothing_nearer_or_farther_than_the_range_is_seen():
    depth = flat(0.5)
    depth[:, :100], depth[:, 200:] = 0.17, 3.05
    seen = ~np.isnan(noisy(depth))
    assert not seen[:, :100].any()
    assert not seen[:, 200:].any()
    assert seen[:, 110:190].mean() > 0.9
    assert np.isnan(noisy(flat(0.174))).all()
    assert not np.isnan(noisy(flat(0.176), speckle=0.0)).any()
    assert np.isnan(noisy(flat(0.6), speckle=0.05)).mean() == pytest.approx(0.05, abs=0.015)


def test_a_near_object_hides_the_ground_to_its_left_only():
    depth = flat(0.6)
    depth[:, 150:200] = 0.3
    missing = np.isnan(noisy(depth, edge_loss=0.0, speckle=0.0))
    # Disparities differ by fx·baseline·(1/0.3 - 1/0.6) = 31.9 px.
    assert missing[:, 120:150].all()
    assert not missing[:, :117].any()
    assert not missing[:, 150:].any()


def test_the_same_seed_gives_the_same_noise_and_leaves_the_image_alone():
    depth = flat(0.6)
    first, second, other = noisy(depth, 1), noisy(depth, 1), noisy(depth, 2)
    assert np.array_equal(first, second, equal_nan=True)
    assert not np.array_equal(first, other, equal_nan=True)
    assert (depth == np.float32(0.6)).all()
    thousandths = first[~np.isnan(first)].astype(float) * 1000.0  # whole millimetres
    assert np.abs(thousandths - np.rint(thousandths)).max() < 1e-3
    assert first.dtype == np.float32
