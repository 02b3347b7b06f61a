"""Grasp feasibility on synthetic height maps with known answers."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from perception.grasps.feasibility import DEPTHS, FLOOR_CLEARANCE, assess
from perception.grasps.hand_geometry import hand_dimensions
from perception.grasps.height_map import CELL, HeightMap
from perception.grasps.object_centroids import ObjectCentroids
from perception.grasps.refinement import refine
from robots import GripperDescription, load_robot

GRIPPER = load_robot("frankie").gripper
HAND = hand_dimensions(GRIPPER)
UP = np.array([0.0, 0.0, 1.0])
FLOOR = 0.456
SIZE = 241
ORIGIN = np.array([-CELL * (SIZE // 2)] * 2)
X, Y = np.meshgrid(ORIGIN[0] + CELL * np.arange(SIZE), ORIGIN[1] + CELL * np.arange(SIZE))

Part = Callable[[np.ndarray, np.ndarray], np.ndarray]


def box(
    x: float, y: float, long: float, wide: float, height: float, yaw_deg: float = 0.0
) -> np.ndarray:
    c, s = np.cos(np.deg2rad(yaw_deg)), np.sin(np.deg2rad(yaw_deg))
    along, across = (X - x) * c + (Y - y) * s, -(X - x) * s + (Y - y) * c
    return np.where((abs(along) <= long / 2) & (abs(across) <= wide / 2), height, 0.0)


def ball(x: float, y: float, radius: float) -> np.ndarray:
    inside = radius**2 - (X - x) ** 2 - (Y - y) ** 2
    return np.where(inside > 0, radius + np.sqrt(np.maximum(inside, 0)), 0.0)


def cone(radius: float, height: float) -> np.ndarray:
    return np.maximum(height * (1.0 - np.hypot(X, Y) / radius), 0.0)


def scene(*parts: np.ndarray) -> HeightMap:
    heights = FLOOR + np.maximum.reduce(list(parts) or [np.zeros_like(X)])
    return HeightMap(heights=heights.astype(np.float32), origin=ORIGIN)


def feasibility(
    where: HeightMap,
    direction_deg: float,
    x: float = 0.0,
    y: float = 0.0,
    gripper: GripperDescription = GRIPPER,
) -> dict[str, float]:
    one = np.ones(1)
    found = assess(where, x * one, y * one, np.deg2rad(direction_deg) * one, FLOOR, gripper)
    return {name: float(getattr(found, name)[0]) for name in found.__dataclass_fields__}


def test_across_a_box_is_good_and_along_it_is_too_wide() -> None:
    where = scene(box(0, 0, 0.12, 0.04, 0.05, yaw_deg=30))
    across = feasibility(where, 120)
    assert across["score"] > 0.9
    assert across["width"] == pytest.approx(0.04, abs=0.003)
    assert across["top"] == pytest.approx(FLOOR + 0.05, abs=1e-4)
    assert across["z"] == pytest.approx(FLOOR + 0.05 - DEPTHS[0], abs=1e-4)
    assert across["width"] + 0.015 < across["opening"] <= GRIPPER.opening
    assert across["z"] + HAND.palm > FLOOR + 0.05
    assert feasibility(where, 30)["score"] == 0.0
    assert feasibility(where, 120, x=-0.04, y=0.05)["score"] == 0.0  # the air beside it
    assert feasibility(scene(), 0)["score"] == 0.0


def test_an_open_hand_that_is_a_little_inaccurate_must_fit_over_a_box() -> None:
    for wide, fits in ((GRIPPER.opening - 0.011, True), (GRIPPER.opening - 0.005, False)):
        assert (feasibility(scene(box(0, 0, 0.12, wide, 0.05)), 90)["score"] > 0) == fits


def test_low_things_are_taken_just_above_the_floor() -> None:
    found = feasibility(scene(box(0, 0, 0.1, 0.03, 0.02)), 90)
    assert found["z"] == pytest.approx(FLOOR + FLOOR_CLEARANCE, abs=1e-4)
    assert found["z"] - HAND.tip > FLOOR
    assert found["score"] > 0.5
    assert feasibility(scene(box(0, 0, 0.1, 0.03, 0.005)), 90)["score"] == 0.0


def test_a_ball_is_good_from_everywhere_and_a_flat_cone_from_nowhere() -> None:
    for direction in (0, 37, 90):
        assert feasibility(scene(ball(0, 0, 0.03)), direction)["score"] > 0.6
        assert feasibility(scene(cone(0.035, 0.03)), direction)["score"] < 0.1


@pytest.mark.parametrize(("gap", "fits"), [(0.010, False), (0.030, True)])
def test_a_neighbour_must_leave_room_for_a_finger(gap: float, fits: bool) -> None:
    neighbour = box(0, 0.02 + gap + 0.03, 0.1, 0.06, 0.05)
    found = feasibility(scene(box(0, 0, 0.1, 0.04, 0.05), neighbour), 90)
    assert (found["score"] > 0) == fits
    if fits:
        finger_outside = found["opening"] / 2 + 0.0158
        assert finger_outside < 0.02 + gap
        assert found["opening"] > found["width"] + 0.007


def test_the_palm_stays_above_tall_neighbours_or_gives_up() -> None:
    tall = box(0, 0.09, 0.04, 0.03, 0.06)
    raised = feasibility(scene(box(0, 0, 0.1, 0.04, 0.04), tall), 90)
    assert raised["z"] + HAND.palm > FLOOR + 0.06
    assert raised["score"] > 0
    taller = box(0, 0.09, 0.04, 0.03, 0.10)
    assert feasibility(scene(box(0, 0, 0.1, 0.04, 0.04), taller), 90)["score"] == 0.0
    # Turned so that the palm is not above it, the same grasp works.
    square = scene(box(0, 0, 0.04, 0.04, 0.04), taller)
    assert feasibility(square, 90)["score"] == 0.0
    assert feasibility(square, 0)["score"] > 0


def test_the_camera_stays_above_what_stands_beside_the_hand() -> None:
    tall = box(0.065, 0.0, 0.02, 0.06, 0.13)
    where = scene(box(0, 0, 0.03, 0.04, 0.05), tall)
    assert feasibility(where, 90)["score"] == 0.0
    assert feasibility(where, 90, gripper=replace(GRIPPER, camera=None))["score"] > 0.0


def test_refining_turns_a_bad_proposal_into_a_good_one() -> None:
    where = scene(box(0.02, 0.01, 0.13, 0.04, 0.05, yaw_deg=20))
    one = np.ones(1)
    found = refine(where, 0.03 * one, 0.02 * one, np.deg2rad(65) * one, 0.8 * one, FLOOR, GRIPPER)
    turn = (np.rad2deg(found.direction[0]) - 110 + 90) % 180 - 90
    assert abs(turn) < 8
    off_axis = -(found.x[0] - 0.02) * np.sin(np.deg2rad(20)) + (found.y[0] - 0.01) * np.cos(
        np.deg2rad(20)
    )
    assert abs(off_axis) < 0.002
    assert (np.diff(found.score) <= 0).all()


def test_of_equal_grasps_the_one_in_the_middle_comes_first() -> None:
    """A bar with a heavy head: its ends and its middle are as good to the fingers."""
    where = scene(box(0.0, 0.0, 0.24, 0.02, 0.03), box(0.10, 0.0, 0.04, 0.06, 0.05))
    centroids = ObjectCentroids(where, FLOOR + 0.008, None)
    at = np.array([-0.09, -0.02, 0.03])
    two = (at, 0 * at, np.full(3, np.pi / 2), np.full(3, 0.8), FLOOR, GRIPPER)
    first = refine(where, *two, directions=1, centroids=centroids).x[0]
    assert abs(first - 0.03) < 0.01
    arms = centroids.at(np.array([0.03, 0.03, -0.11]), np.array([0.0, 0.1, 0.0]))
    assert arms[0] < 0.03
    assert arms[1] == 0.0  # beside it
    assert arms[2] > 0.1
    assert centroids.preference(np.array([0.03]), np.zeros(1))[0] > 0.6
    assert refine(where, *two, directions=1).score.max() > 0
    too_wide = scene(box(0, 0, 0.2, 0.15, 0.05))
    assert len(refine(too_wide, *two).score) == 0
    empty = np.zeros(0)
    assert len(refine(where, empty, empty, empty, empty, FLOOR, GRIPPER).score) == 0


def test_the_middle_of_what_the_image_cuts_off_is_unknown() -> None:
    """A bar that leaves the image at its right end, and a ball beside it."""
    where = scene(box(0.1, 0.0, 0.16, 0.03, 0.04), ball(-0.1, 0.0, 0.02))
    y = np.linspace(-0.1, 0.1, 50)
    x = np.full_like(y, X.max())
    border = np.stack([x, y, where.at(x, y)], axis=1)
    centroids = ObjectCentroids(where, FLOOR + 0.008, None, border)
    at = np.array([0.1, 0.16, -0.1, 0.0]), np.zeros(4)
    assert centroids.shows_all(*at).tolist() == [False, False, True, True]
    assert ObjectCentroids(where, FLOOR + 0.008, None).shows_all(*at).all()
