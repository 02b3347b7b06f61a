"""What is seen around a grasp, and what the shipped network makes of it."""

from pathlib import Path

import numpy as np
import pytest

from perception import NUMBERS, GraspPatches, WeightsError
from perception.grasp_patches import NEAR_CELL, NEAR_SHAPE, grasp_patches
from perception.height_map import CELL, HeightMap
from perception.lever_arm import LeverArms
from perception.networks import load_hold, shipped_hold
from perception.refine import RefinedGrasps, refine
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
    levers = LeverArms(scene, FLOOR + 0.008, None)
    return grasp_patches(scene, found, levers, CAMERA, FLOOR)


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


def test_what_is_unknown_is_seen_as_such() -> None:
    scene = bar(0.09)
    assert scene.unknown is not None
    scene.unknown[X > 0.06] = True
    seen = seen_at(scene, 0.0)
    assert not seen.near_unknown.any()
    rows = seen.far_unknown[0].mean(axis=1)
    assert set(np.rint(rows)) == {0.0, 1.0}
    assert 0.25 < rows.mean() < 0.4


@pytest.mark.parametrize("width", [0.03, 0.045, 0.06])
def test_the_shipped_network_trusts_the_middle_of_a_long_bar_most(width: float) -> None:
    hold = shipped_hold()
    middle, aside, end = (float(hold(seen_at(bar(0.28, width), x))[0]) for x in (0.0, 0.09, 0.13))
    assert 0.8 < end < aside < middle < 1.0


def test_grasps_are_ranked_by_what_is_told_of_them() -> None:
    one = np.ones(3)
    found = RefinedGrasps(
        x=np.array([1.0, 2.0, 3.0]),
        y=one,
        z=one,
        top=one,
        direction=one,
        width=one,
        opening=one,
        score=np.array([0.9, 0.8, 0.7]),
    )
    ranked = found.ranked(np.array([0.1, 0.6, 0.3]))
    assert list(ranked.x) == [2.0, 3.0, 1.0]
    assert list(ranked.score) == [0.6, 0.3, 0.1]


def test_weights_of_another_network_are_refused() -> None:
    bins = Path(__file__).parents[2] / "perception" / "weights" / "bins.safetensors"
    with pytest.raises(WeightsError, match="not those of HoldNetwork"):
        load_hold(bins)
