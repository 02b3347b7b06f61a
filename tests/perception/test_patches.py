"""Height patches around a grasp, and the shipped hold network on them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from perception import NUMBERS, GraspPatches, WeightsError
from perception.grasps.height_map import CELL, HeightMap
from perception.grasps.object_centroids import ObjectCentroids
from perception.grasps.patches import NEAR_CELL, NEAR_SHAPE, grasp_patches
from perception.grasps.refinement import refine
from perception.networks import load_hold, shipped_hold
from robots import load_robot

GRIPPER = load_robot("frankie").gripper
FLOOR = 0.456
SIZE = 401
ORIGIN = np.array([-CELL * (SIZE // 2)] * 2)
X, Y = np.meshgrid(ORIGIN[0] + CELL * np.arange(SIZE), ORIGIN[1] + CELL * np.arange(SIZE))
CAMERA = np.array([0.0, 0.0, FLOOR + 0.45])


def bar(length: float, width: float = 0.03, height: float = 0.03) -> HeightMap:
    """A bar along x."""
    on = (np.abs(X) <= length / 2) & (np.abs(Y) <= width / 2)
    heights = (FLOOR + np.where(on, height, 0.0)).astype(np.float32)
    unknown = np.zeros(heights.shape, dtype=np.bool_)
    return HeightMap(heights=heights, origin=ORIGIN, unknown=unknown)


def seen_at(scene: HeightMap, x: float, direction: float = np.pi / 2) -> GraspPatches:
    one = np.ones(1)
    found = refine(scene, x * one, 0.0 * one, direction * one, one, FLOOR, GRIPPER, directions=1)
    assert len(found.score) == 1
    centroids = ObjectCentroids(scene, FLOOR + 0.008, None)
    return grasp_patches(scene, found, centroids, CAMERA, FLOOR)


def test_the_maps_turn_with_the_grasp_and_are_relative_to_it() -> None:
    scene = bar(0.09)
    seen = seen_at(scene, 0.0)
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
def test_the_shipped_network_trusts_the_middle_of_a_long_bar_most(
    width: float, least: float
) -> None:
    hold = shipped_hold(GRIPPER)
    assert hold is not None
    middle, aside, end = (float(hold(seen_at(bar(0.28, width), x))[0]) for x in (0.0, 0.09, 0.13))
    assert least < end < aside < middle < 1.0


def test_weights_of_another_network_are_refused() -> None:
    ggcnn = Path(__file__).parents[2] / "perception" / "weights" / "ggcnn.safetensors"
    with pytest.raises(WeightsError, match="not those of HoldNetwork"):
        load_hold(ggcnn, GRIPPER)
