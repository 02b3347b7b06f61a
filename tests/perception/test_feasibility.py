"""Feasibility of grasps on synthetic height maps, patches around them, and the hold network."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from perception import NUMBERS, GraspPatches, WeightsError
from perception.grasps.feasibility import DEPTHS, FLOOR_CLEARANCE, assess
from perception.grasps.hand_geometry import hand_dimensions
from perception.grasps.height_map import CELL, HeightMap
from perception.grasps.object_centroids import ObjectCentroids
from perception.grasps.patches import NEAR_CELL, NEAR_SHAPE, grasp_patches
from perception.grasps.refinement import refine
from perception.networks.hold import load_hold, shipped_hold
from robots import load_robot

GRIPPER = load_robot("frankie").gripper


HAND = hand_dimensions(GRIPPER)


FLOOR = 0.456


SIZE = 401


ORIGIN = np.array([-CELL * (SIZE // 2)] * 2)


X, Y = np.meshgrid(ORIGIN[0] + CELL * np.arange(SIZE), ORIGIN[1] + CELL * np.arange(SIZE))


def box(x, y, long, wide, height, yaw_deg=0.0) -> np.ndarray:
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


def feasibility(where: HeightMap, direction_deg, x=0.0, y=0.0, gripper=GRIPPER) -> dict[str, float]:
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
    s, c = np.sin(np.deg2rad(20)), np.cos(np.deg2rad(20))
    assert abs((found.y[0] - 0.01) * c - (found.x[0] - 0.02) * s) < 0.002, "beside its axis"
    assert (np.diff(found.score) <= 0).all()


def test_of_equal_grasps_the_one_in_the_middle_comes_first() -> None:
    """A bar with a heavy head: its ends and its middle are as good to the fingers."""
    where = scene(box(0.0, 0.0, 0.24, 0.02, 0.03), box(0.10, 0.0, 0.04, 0.06, 0.05))
    centroids = ObjectCentroids(where, FLOOR + 0.008, None)
    at = np.array([-0.09, -0.02, 0.03])
    two = (at, 0 * at, np.full(3, np.pi / 2), np.full(3, 0.8), FLOOR, GRIPPER)
    first = refine(where, *two, directions=1, centroids=centroids).x[0]
    assert abs(first - 0.03) < 0.01
    arms = centroids.at(np.array([0.03, 0.03, -0.11]), np.array([0.0, 0.1, 0.0])).lever
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
    where = scene(box(0.2, 0.0, 0.2, 0.03, 0.04), ball(-0.1, 0.0, 0.02))
    y = np.linspace(-0.1, 0.1, 50)
    x = np.full_like(y, X.max())
    border = np.stack([x, y, where.at(x, y)], axis=1)
    centroids = ObjectCentroids(where, FLOOR + 0.008, None, border)
    at = np.array([0.2, 0.28, -0.1, 0.0]), np.zeros(4)
    assert centroids.at(*at).whole.tolist() == [False, False, True, True]
    assert ObjectCentroids(where, FLOOR + 0.008, None).at(*at).whole.all()


CAMERA = np.array([0.0, 0.0, FLOOR + 0.45])


def bar(length: float, width: float = 0.03, height: float = 0.03) -> HeightMap:
    """A bar along x, all of which was seen."""
    return replace(scene(box(0, 0, length, width, height)), unknown=np.zeros(X.shape, bool))


def seen_at(where: HeightMap, x: float) -> GraspPatches:
    one = np.ones(1)
    at = x * one, 0.0 * one, np.pi / 2 * one, one
    found = refine(where, *at, FLOOR, GRIPPER, directions=1)
    assert len(found.score) == 1
    centroids = ObjectCentroids(where, FLOOR + 0.008, None)
    return grasp_patches(where, found, centroids, CAMERA, FLOOR)


def test_the_maps_turn_with_the_grasp_and_are_relative_to_it() -> None:
    seen = seen_at(bar(0.09), 0.0)
    depth = seen.numbers[0, NUMBERS.index("depth")]
    across, along = (NEAR_CELL * (np.arange(n) - (n - 1) / 2) for n in NEAR_SHAPE)
    # The hand closes along y, so the bar lies across: all rows, and the middle columns.
    on = (np.abs(across)[:, None] < 0.043) & (np.abs(along)[None, :] < 0.013)
    off = np.abs(along) > 0.018
    assert seen.near[0][on] == pytest.approx(depth, abs=2e-3)
    assert (seen.near[0][:, off] < depth - 0.028).all()


def test_the_numbers_say_where_the_middle_is() -> None:
    seen = seen_at(bar(0.2), 0.06)
    told = dict(zip(NUMBERS, seen.numbers[0], strict=True))
    assert told["width"] == pytest.approx(0.03, abs=0.003)
    assert np.hypot(told["middle_along"], told["middle_across"]) == pytest.approx(0.06, abs=0.004)
    assert abs(told["middle_along"]) < 0.004
    assert told["volume"] == pytest.approx(0.2 * 0.03 * 0.022, rel=0.1)


def test_there_is_no_hold_estimate_for_another_hand() -> None:
    wider = replace(GRIPPER, opening=GRIPPER.opening + 0.02)
    assert shipped_hold(GRIPPER) is not None
    assert shipped_hold(wider) is None


@pytest.mark.parametrize(("width", "least"), [(0.03, 0.6), (0.06, 0.8)])
def test_the_shipped_network_trusts_the_middle_of_a_long_bar_most(width, least):
    places = [seen_at(bar(0.28, width), x) for x in (0.13, 0.09, 0.0)]
    end, aside, middle = (float(shipped_hold(GRIPPER)(place)[0]) for place in places)
    assert least < end < aside < middle < 1.0


def test_weights_of_another_network_are_refused() -> None:
    ggcnn = Path(__file__).parents[2] / "perception" / "weights" / "ggcnn.safetensors"
    with pytest.raises(WeightsError, match="not those of `hold`"):
        load_hold(ggcnn, GRIPPER)
