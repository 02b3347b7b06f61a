"""Velocity of a grasped object, from synthetic sequences of detections."""

from dataclasses import replace

import numpy as np
import pytest
from test_tracker import FAR, camera, grasp, seen

from perception import GraspTracker


def followed_along(places: np.ndarray, height: float = 0.45, *, whole: bool = True) -> GraspTracker:
    """A tracker that has seen a grasp at (N, 2) places, 30 times a second."""
    tracker = GraspTracker(lock_distance=0.25)
    for number, (x, y) in enumerate(places):
        one = replace(grasp(x, y), middle=(x, y) if whole else None)
        tracker.update(seen(one, at=number / 30.0), camera(height))
    return tracker


def along_x(speed: float, frames: int) -> np.ndarray:
    """(frames, 2) places of what moves [m]."""
    return np.outer(np.arange(frames) / 30.0, [speed, 0.0])


def test_what_moves_is_expected_where_it_will_have_come_also_once_it_is_locked() -> None:
    rng = np.random.default_rng(0)
    times = np.arange(30) / 30.0
    places = np.outer(times, [0.1, 0.0]) + rng.normal(0.0, 0.001, (30, 2))
    tracker = followed_along(places)
    followed = tracker.update(seen(grasp(0.1, 0.0), at=1.0), camera(0.2))
    assert tracker.locked
    np.testing.assert_allclose(followed.velocity, [0.1, 0.0, 0.0], atol=0.02)
    np.testing.assert_allclose(followed.wTg_at(1.0).translation, [0.1, 0.0, 0.48], atol=0.004)
    np.testing.assert_allclose(followed.wTg_at(2.0).translation, [0.2, 0.0, 0.48], atol=0.02)
    assert tracker.update(seen(reason="too near", at=2.0), camera(0.15)) is followed
    stopped = followed_along(
        np.concatenate([along_x(0.1, 15), np.tile([14 / 300.0, 0.0], (25, 1))])
    )
    still = stopped.update(seen(grasp(14 / 300.0, 0.0), at=40 / 30.0), FAR)
    assert still is not None
    assert not still.velocity.any()


def test_a_grasp_that_trembles_and_shifts_slowly_stands_still() -> None:
    rng = np.random.default_rng(1)
    places = np.outer(np.arange(60) / 30.0, [0.03, 0.0]) + rng.normal(0.0, 0.003, (60, 2))
    tracker = GraspTracker()
    for number, (x, y) in enumerate(places):
        followed = tracker.update(seen(grasp(x, y), at=number / 30.0), FAR)
        assert followed is not None
        assert not followed.velocity.any()
        assert followed.twist is None


@pytest.mark.parametrize("whole", [True, False])
def test_a_grasp_that_slides_along_a_thing_does_not_move_nor_does_a_thing_cut_off(whole) -> None:
    tracker = GraspTracker()
    for number in range(30):
        x = 0.004 * number
        middle = (0.05, 0.0) if whole else None
        sliding = replace(grasp(x, 0.0), middle=middle)
        followed = tracker.update(seen(sliding, at=number / 30.0), FAR)
        assert followed is not None
        assert not followed.velocity.any()


def test_it_is_not_locked_before_it_is_known_whether_it_moves_or_that_was_given_up() -> None:
    assert not followed_along(np.zeros((4, 2)), height=0.2).locked
    assert followed_along(np.zeros((6, 2)), height=0.2).locked
    assert not followed_along(np.zeros((6, 2)), height=0.2, whole=False).locked
    assert followed_along(np.zeros((8, 2)), height=0.2, whole=False).locked


def test_how_it_moves_is_known_although_its_middle_is_soon_seen_no_longer() -> None:
    """As from near, where the image cuts it off."""
    tracker = followed_along(along_x(0.1, 5))
    for number in range(5, 20):
        (x, y) = along_x(0.1, 20)[number]
        unknown = replace(grasp(x, y), middle=None)
        followed = tracker.update(seen(unknown, at=number / 30.0), camera(0.3))
    assert followed is not None
    np.testing.assert_allclose(followed.velocity, [0.1, 0.0, 0.0], atol=0.001)


def test_a_middle_that_is_not_on_its_way_is_left_out() -> None:
    """Half of the thing was hidden, and nobody knew."""
    tracker = followed_along(along_x(0.1, 8))
    x, y = along_x(0.1, 20)[19]
    half = replace(grasp(x, y), middle=(x + 0.02, y + 0.02))
    followed = tracker.update(seen(half, at=19 / 30.0), FAR)
    assert followed is not None
    np.testing.assert_allclose(followed.velocity, [0.1, 0.0, 0.0], atol=0.001)


@pytest.mark.parametrize("whole", [True, False])
def test_how_it_moves_is_not_forgotten_while_it_is_out_of_sight(whole: bool) -> None:
    tracker = followed_along(along_x(0.1, 8))
    for number in range(8, 25):
        assert not tracker.locked
        gone = tracker.update(seen(reason="out of sight", at=number / 30.0), camera(0.3))
    assert gone is None
    x, y = along_x(0.1, 26)[25]
    again = replace(grasp(x, y), middle=(x, y) if whole else None)
    followed = tracker.update(seen(again, at=25 / 30.0), camera(0.3))
    assert followed is not None
    np.testing.assert_allclose(followed.velocity, [0.1, 0.0, 0.0], atol=0.001)
