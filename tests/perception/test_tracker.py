"""Tracking of one grasp through synthetic sequences of detections."""

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
        wTg=SE3(turn @ DOWN, np.array([x, y, 0.48])),
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
    assert estimate is not None
    return np.asarray(estimate.wTg.translation)


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
    assert first is not None
    for frame in range(20):
        yaw = -89.0 if frame % 2 else 89.0
        followed = tracker.update(seen(grasp(0.0, 0.0, yaw_deg=yaw)), FAR)
        assert followed is not None
        closing = first.wTg.rotation[:, 1] @ followed.wTg.rotation[:, 1]
        assert closing > np.cos(np.deg2rad(5.0))


def test_near_the_grasp_the_goal_is_locked_and_moves_no_more() -> None:
    tracker = GraspTracker(lock_distance=0.25)
    tracker.update(seen(grasp(0.0, 0.0)), camera(0.26))
    assert not tracker.locked
    locked = tracker.update(seen(grasp(0.0, 0.0), at=0.4), camera(0.24))
    assert tracker.locked
    moved = tracker.update(seen(grasp(0.02, 0.0, quality=0.99)), camera(0.23))
    assert moved is locked
    blind = tracker.update(seen(reason="hardly any depth was measured"), camera(0.15))
    assert blind is locked
    back_up = tracker.update(seen(grasp(0.1, 0.0)), camera(0.5))
    assert back_up is locked
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
    tracker.reject(bad.wTg)
    tracker.reset()
    assert position(tracker.update(seen(bad, other), FAR))[0] == pytest.approx(0.1)
    tracker.reset()
    assert tracker.update(seen(bad), FAR) is None
    assert "failed before" in tracker.reason
    tracker.forget()
    assert position(tracker.update(seen(bad, other), FAR))[0] == pytest.approx(0.0)


def test_a_failed_grasp_is_avoided_where_it_is_on_the_map_while_odometry_drifts():
    tracker, other = GraspTracker(), grasp(0.1, 0.0, quality=0.8)
    tracker.reject(grasp(0.0, 0.0).wTg)
    tracker.mTw = SE3(np.eye(3), np.array([-0.1, 0.0, 0.0]))
    assert position(tracker.update(seen(other, grasp(0.2, 0.0, quality=0.5)), FAR))[0] > 0.15


def test_at_another_depth_along_its_approach_it_is_the_same_grasp() -> None:
    level = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]) @ DOWN

    def at(x: float, z: float) -> GraspEstimate:
        return replace(grasp(0.0, 0.0), wTg=SE3(level, np.array([x, 0.0, z])), middle=None)

    tracker = GraspTracker()
    tracker.update(seen(at(0.0, 0.5)), FAR)
    assert position(tracker.update(seen(at(0.05, 0.5)), FAR))[0] == pytest.approx(0.02)
    assert position(tracker.update(seen(at(0.05, 0.55)), FAR))[2] == pytest.approx(0.5)
