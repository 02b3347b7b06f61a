"""Tracking of one grasp and its velocity through synthetic sequences of detections."""

from dataclasses import replace

import numpy as np
import pytest
from pinocchio import SE3, exp3

from perception import Detection, GraspEstimate, GraspTracker
from perception.grasps.tracker import LOST_AFTER, SWITCH_AFTER

DOWN = np.diag([1.0, -1.0, -1.0])


def grasp(x: float, y: float, yaw_deg: float = 0.0, quality: float = 0.6) -> GraspEstimate:
    turn = exp3(np.array([0.0, 0.0, np.deg2rad(yaw_deg)]))
    return GraspEstimate(
        oTg=SE3(turn @ DOWN, np.array([x, y, 0.48])),
        width=0.04,
        opening=0.06,
        quality=quality,
        stamp=0.0,
        pixel=(0.0, 0.0),
        angle=0.0,
        middle=(x, y),
    )


def seen(*grasps: GraspEstimate, reason: str = "", at: float = 0.0) -> Detection:
    ranked = tuple(sorted((replace(g, stamp=at) for g in grasps), key=lambda g: -g.quality))
    return Detection(
        grasps=ranked,
        reason=reason,
        quality=np.zeros((300, 300), dtype=np.float32),
        crop=(0.0, 0.0, 300.0),
        stamp=at,
    )


def camera(height: float) -> SE3:
    return SE3(DOWN, np.array([0.0, 0.0, 0.48 + height]))


FAR = camera(0.45)


def position(estimate: GraspEstimate | None) -> np.ndarray:
    return np.asarray(estimate.oTg.translation)


def test_the_tracker_does_not_switch_to_what_the_image_cuts_off() -> None:
    tracker = GraspTracker()
    first = tracker.update(seen(grasp(0.0, 0.0, quality=0.3), grasp(0.2, 0.0, quality=0.2)), FAR)
    assert position(first)[0] == pytest.approx(0.0)
    cut_off = replace(grasp(0.1, 0.0, quality=0.9), whole=False)
    for _ in range(10):
        followed = tracker.update(seen(grasp(0.0, 0.0, quality=0.3), cut_off), FAR)
    assert position(followed)[0] == pytest.approx(0.0)
    for _ in range(10):
        followed = tracker.update(seen(grasp(0.0, 0.0, quality=0.3), grasp(0.1, 0.0)), FAR)
    assert position(followed)[0] == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("quality", "other", "x"),
    [(0.4, 0.9, 0.2), (0.3, 0.43, 0.2), (0.8, 0.95, 0.2), (0.8, 0.9, 0.0), (0.98, 0.99, 0.0)],
)
def test_one_that_stays_clearly_better_is_followed_instead(quality, other, x) -> None:
    """Of likely ones the odds decide."""
    tracker = GraspTracker()
    tracker.update(seen(grasp(0.0, 0.0, quality=quality)), FAR)
    both = seen(grasp(0.0, 0.0, quality=quality), grasp(0.2, 0.0, quality=other))
    for _ in range(SWITCH_AFTER - 1):
        assert position(tracker.update(both, FAR))[0] == pytest.approx(0.0)
    assert position(tracker.update(both, FAR))[0] == pytest.approx(x)


def test_noise_is_smoothed_and_a_moving_object_followed() -> None:
    rng = np.random.default_rng(0)
    tracker = GraspTracker()
    errors = []
    for _ in range(200):
        dx, dy = rng.normal(0.0, 0.004, 2)
        errors.append(position(tracker.update(seen(grasp(dx, dy)), FAR))[:2])
    assert np.std(errors[20:]) < 0.6 * 0.004
    for frame in range(60):
        followed = tracker.update(seen(grasp(0.002 * frame, 0.0)), FAR)
    assert position(followed)[0] == pytest.approx(0.118, abs=0.005)


def test_exchanged_fingers_are_the_same_grasp() -> None:
    """A grasp near the edge of the range of angles comes out turned by half a turn at times."""
    tracker = GraspTracker()
    first = tracker.update(seen(grasp(0.0, 0.0, yaw_deg=88.0)), FAR)
    for frame in range(20):
        yaw = -89.0 if frame % 2 else 89.0
        followed = tracker.update(seen(grasp(0.0, 0.0, yaw_deg=yaw)), FAR)
        closing = first.oTg.rotation[:, 1] @ followed.oTg.rotation[:, 1]
        assert closing > np.cos(np.deg2rad(5.0))


def test_near_the_grasp_the_goal_is_locked_and_moves_no_more() -> None:
    tracker = GraspTracker(lock_distance=0.25)
    tracker.update(seen(grasp(0.0, 0.0)), camera(0.26))
    assert not tracker.locked
    locked = tracker.update(seen(grasp(0.0, 0.0), at=0.4), camera(0.24))
    assert tracker.locked
    assert tracker.update(seen(grasp(0.02, 0.0, quality=0.99)), camera(0.23)) is locked
    assert tracker.update(seen(reason="hardly any depth was measured"), camera(0.15)) is locked
    assert tracker.update(seen(grasp(0.1, 0.0)), camera(0.5)) is locked
    tracker.reset()
    assert not tracker.locked
    at_once = GraspTracker(lock_distance=np.inf)
    at_once.update(seen(grasp(0.0, 0.0)), FAR)
    assert at_once.locked


@pytest.mark.parametrize(("driven", "speed"), [(0.3, 0.0), (0.0, 0.1)])
def test_an_old_picture_locks_no_grasp_until_the_hand_waits_and_none_that_moves(driven, speed):
    tracker = GraspTracker()
    for number in range(8):  # searches of half a second
        stamp = 0.5 * number
        found = seen(grasp(speed * stamp, 0.0), at=stamp)
        tracker.update(found, camera(0.2), age=0.5, driven=driven)
        assert not tracker.locked
    tracker.update(seen(grasp(speed * 4.0, 0.0), at=4.0), camera(0.2), age=0.5)
    assert tracker.locked is (speed == 0.0)


def test_a_grasp_that_is_not_seen_again_is_lost_with_a_reason() -> None:
    tracker = GraspTracker()
    tracker.update(seen(grasp(0.0, 0.0)), FAR)
    for _ in range(LOST_AFTER - 1):
        tracker.update(seen(), FAR)
    tracker.update(seen(grasp(0.0, 0.0)), FAR)  # the count starts anew
    for _ in range(LOST_AFTER - 1):
        assert tracker.update(seen(reason="nothing stands out"), FAR) is not None
    assert tracker.update(seen(reason="nothing stands out"), FAR) is None
    assert str(LOST_AFTER) in tracker.reason
    assert tracker.update(seen(reason="nothing stands out"), FAR) is None
    assert tracker.reason == "nothing stands out"
    assert tracker.update(seen(grasp(0.1, 0.1)), FAR) is not None
    assert tracker.reason == ""


def test_a_failed_grasp_is_avoided_until_forgotten() -> None:
    tracker = GraspTracker()
    bad, other = grasp(0.0, 0.0, quality=0.9), grasp(0.1, 0.0, quality=0.5)
    tracker.reject(bad.oTg)
    tracker.reset()
    assert position(tracker.update(seen(bad, other), FAR))[0] == pytest.approx(0.1)
    tracker.reset()
    assert tracker.update(seen(bad), FAR) is None
    assert "failed before" in tracker.reason
    tracker.forget()
    assert position(tracker.update(seen(bad, other), FAR))[0] == pytest.approx(0.0)


def test_a_failed_grasp_is_avoided_where_it_is_on_the_map_while_odometry_drifts():
    tracker, other = GraspTracker(), grasp(0.1, 0.0, quality=0.8)
    tracker.reject(grasp(0.0, 0.0).oTg)
    tracker.mTo = SE3(np.eye(3), np.array([-0.1, 0.0, 0.0]))
    assert position(tracker.update(seen(other, grasp(0.2, 0.0, quality=0.5)), FAR))[0] > 0.15


def test_at_another_depth_along_its_approach_it_is_the_same_grasp() -> None:
    level = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]) @ DOWN

    def at(x: float, z: float) -> GraspEstimate:
        return replace(grasp(0.0, 0.0), oTg=SE3(level, np.array([x, 0.0, z])), middle=None)

    tracker = GraspTracker()
    tracker.update(seen(at(0.0, 0.5)), FAR)
    assert position(tracker.update(seen(at(0.05, 0.5)), FAR))[0] == pytest.approx(0.02)
    assert position(tracker.update(seen(at(0.05, 0.55)), FAR))[2] == pytest.approx(0.5)


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
    tremor = np.random.default_rng(0).normal(0.0, 0.001, (30, 2))
    tracker = followed_along(along_x(0.1, 30) + tremor)
    followed = tracker.update(seen(grasp(0.1, 0.0), at=1.0), camera(0.2))
    assert tracker.locked
    np.testing.assert_allclose(followed.velocity, [0.1, 0.0, 0.0], atol=0.02)
    np.testing.assert_allclose(followed.oTg_at(1.0).translation, [0.1, 0.0, 0.48], atol=0.004)
    np.testing.assert_allclose(followed.oTg_at(2.0).translation, [0.2, 0.0, 0.48], atol=0.02)
    assert tracker.update(seen(reason="too near", at=2.0), camera(0.15)) is followed
    *_, end = moving = along_x(0.1, 15)
    stopped = followed_along(np.vstack([moving, np.tile(end, (25, 1))]))
    still = stopped.update(seen(grasp(*end), at=40 / 30.0), FAR)
    assert not still.velocity.any()


def test_a_grasp_that_trembles_and_shifts_slowly_stands_still() -> None:
    places = along_x(0.03, 60) + np.random.default_rng(1).normal(0.0, 0.003, (60, 2))
    tracker = GraspTracker()
    for number, (x, y) in enumerate(places):
        followed = tracker.update(seen(grasp(x, y), at=number / 30.0), FAR)
        assert not followed.velocity.any()
        assert followed.twist is None


@pytest.mark.parametrize("whole", [True, False])
def test_a_grasp_that_slides_along_a_thing_does_not_move_nor_does_a_thing_cut_off(whole) -> None:
    tracker = GraspTracker()
    for number in range(30):
        sliding = replace(grasp(0.004 * number, 0.0), middle=(0.05, 0.0) if whole else None)
        followed = tracker.update(seen(sliding, at=number / 30.0), FAR)
        assert not followed.velocity.any()


def test_it_is_not_locked_before_it_is_known_whether_it_moves_or_that_was_given_up() -> None:
    assert not followed_along(np.zeros((4, 2)), height=0.2).locked
    assert followed_along(np.zeros((6, 2)), height=0.2).locked
    assert not followed_along(np.zeros((6, 2)), height=0.2, whole=False).locked
    assert followed_along(np.zeros((8, 2)), height=0.2, whole=False).locked


def test_a_middle_that_is_not_on_its_way_is_left_out() -> None:
    """Half of the object was hidden, and nobody knew."""
    tracker = followed_along(along_x(0.1, 8))
    x, y = along_x(0.1, 20)[19]
    half = replace(grasp(x, y), middle=(x + 0.02, y + 0.02))
    followed = tracker.update(seen(half, at=19 / 30.0), FAR)
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
    np.testing.assert_allclose(followed.velocity, [0.1, 0.0, 0.0], atol=0.001)
