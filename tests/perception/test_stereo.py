"""Stereo depth: smoothing, holes and their causes, and what was seen there on the way."""

from dataclasses import replace

import numpy as np
import pytest
from pinocchio import SE3
from test_detector import (
    CAMERA,
    FLOOR,
    GRIPPER,
    WORKSPACE,
    box_world,
    detector,
    frame,
    looking_down,
)
from test_tracker import grasp

from hw import DepthFrame
from hw.sim import World
from perception import DepthCloud, GraspDetector, GraspEstimate, HeightMap, SceneMemory
from perception.grasps.feasibility import assess
from perception.grasps.height_map import local_heights
from perception.grasps.network_input import gaps_in, scaled_crop
from perception.grasps.scene_memory import completed
from perception.grasps.stereo import BASELINE, smoothed, unknown_pixels
from robots import Box, Geom

FX = 400.0


def image_with_hole(begin: int, end: int, near: float = 0.3, far: float = 0.6) -> np.ndarray:
    """The far surface left of a hole and the near one right of it."""
    depth = np.full((40, 120), far, dtype=np.float32)
    depth[:, end:] = near
    depth[:, begin:end] = np.nan
    return depth


def unknown_share(depth: np.ndarray) -> float:
    missing = np.isnan(depth)
    return float(unknown_pixels(depth, missing, gaps_in(missing), FX, 0.6)[missing].mean())


def test_only_a_hole_wider_than_any_shadow_is_unknown() -> None:
    shadow = round(FX * BASELINE * (1 / 0.3 - 1 / 0.6))
    assert unknown_share(image_with_hole(40, 40 + shadow)) == 0.0
    assert unknown_share(image_with_hole(40, 60 + shadow)) == 1.0
    assert unknown_share(image_with_hole(40, 40 + shadow, near=0.59)) == 1.0
    speckle, rows = (np.full((40, 120), 0.6, dtype=np.float32) for _ in range(2))
    speckle[10:14, 50:54] = np.nan
    assert unknown_share(speckle) == 0.0
    rows[10:25] = np.nan  # without neighbours
    assert unknown_share(rows) == 1.0


def seen_from(oTc: SE3, hole: int = 0) -> HeightMap:
    """A box on a wide floor, with a square hole of so many pixels in the middle of the image."""
    floor = Geom(Box((2.0, 2.0, 0.1)), SE3(np.eye(3), np.array([3.0, 0.0, FLOOR - 0.1])), "floor")
    world = World([floor], box_world(yaw=0.0, x=3.0, y=0.0).objects)
    seen = frame(world, oTc)
    depth = np.array(seen.depth)
    rows, columns = (slice(n // 2 - hole // 2, n // 2 + hole // 2) for n in depth.shape)
    depth[rows, columns] = np.nan
    support = float((FLOOR - oTc.translation[2]) / oTc.rotation[2, 2])
    crop = scaled_crop(depth.shape, CAMERA, support)
    return local_heights(seen.cloud.measuring(depth), crop, support).scene


def unknown_at(found: HeightMap, x: float, y: float) -> bool:
    return bool(found.unknown.ravel()[found.cells(np.array([x]), np.array([y]))][0])


def test_what_is_beyond_the_image_is_unknown_and_what_a_thing_hides_is_not() -> None:
    tilted = looking_down(0.45, tilt=(0.35, 0.0))
    ahead = tilted.rotation[:, 2] * 0.45 / -tilted.rotation[2, 2]
    tilted.translation[:2] -= ahead[:2]  # the box is in the middle of the image
    found = seen_from(tilted)
    behind = 0.028 * np.sign(ahead[1])
    assert not unknown_at(found, 3.0, behind)
    assert not unknown_at(found, 3.0, 0.0)
    assert unknown_at(found, 3.0, -0.6)
    assert unknown_at(found, 3.0, 0.6)
    assert unknown_at(found, 3.6, 0.0)


def test_a_thing_that_gives_no_depth_is_unknown_where_it_stands() -> None:
    assert not unknown_at(seen_from(looking_down(0.4)), 3.0, 0.0)
    found = seen_from(looking_down(0.4), hole=80)
    assert unknown_at(found, 3.0, 0.0)
    assert not unknown_at(found, 3.1, 0.0)
    unknown = seen_from(looking_down(0.45, yaw=0.4)).unknown
    assert all(edge.all() for edge in (unknown[0], unknown[-1], unknown[:, 0], unknown[:, -1]))


def beside_a_column(height: float) -> tuple[HeightMap, float]:
    """What a camera 0.3 m above the floor sees of it, and the score of a grasp 70 mm beside it."""
    floor = Geom(Box((2.0, 2.0, 0.1)), SE3(np.eye(3), np.array([3.0, 0.0, FLOOR - 0.1])), "floor")
    boxes = [
        Geom(Box(half), SE3(np.eye(3), np.array([3.0, y, FLOOR + half[2]])), "box")
        for y, half in ((0.0, (0.02, 0.02, 0.035)), (0.07, (0.02, 0.01, 0.5 * height)))
    ]
    oTc = looking_down(0.3)
    oTc.translation[1] -= 0.02  # so that the side of the column is seen
    seen = frame(World([floor, *boxes], []), oTc)
    around = local_heights(seen.cloud, scaled_crop((480, 640), CAMERA, 0.3), 0.3)
    at = 3.0 * np.ones(1), np.zeros(1), 0.5 * np.pi * np.ones(1)
    return around.scene, float(assess(around.scene, *at, FLOOR, GRIPPER).score[0])


def test_the_palm_does_not_meet_what_is_within_the_minimum_range() -> None:
    low, fits = beside_a_column(0.09)
    assert low.rising is None
    assert fits > 0.0
    tall, score = beside_a_column(0.24)
    assert tall.rising.ravel()[tall.cells(np.array([3.0]), np.array([0.07]))].all()
    assert not tall.rising.ravel()[tall.cells(np.array([3.1]), np.array([0.0]))].any()
    assert score == 0.0


def step(near: float, far: float, noise: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """The true depth of a step and what a stereo camera measures, with a noise in pixels."""
    true = np.full((60, 80), far, dtype=np.float32)
    true[20:40, 30:50] = near
    disparity = FX * BASELINE / true
    disparity += noise * np.random.default_rng(seed).standard_normal(true.shape)
    return true, (FX * BASELINE / disparity).astype(np.float32)


def after_smoothing(depth: np.ndarray) -> np.ndarray:
    camera = replace(CAMERA, fx=FX)
    return smoothed(DepthCloud(depth=depth, intrinsics=camera, oTc=SE3.Identity())).depth


def test_smoothing_improves_far_surfaces_and_keeps_edges() -> None:
    true, measured = step(1.5, 1.5, noise=0.1)
    before, after = (np.std(depth - true) for depth in (measured, after_smoothing(measured)))
    assert before == pytest.approx(0.0113, rel=0.1)
    assert after < before / 3
    true, measured = step(1.35, 1.5, noise=0.05)
    edge = 0.5 * (1.35 + 1.5)
    assert np.mean((after_smoothing(measured) < edge) == (true < edge)) > 0.999


__all__ = ["detector"]  # a fixture


BOX = box_world(yaw=0.0, x=3.0, y=0.0)


def from_afar(stamp: float, world: World = BOX) -> DepthFrame:
    """The whole container."""
    return replace(frame(world, looking_down(0.5)), stamp=stamp)


def from_near(stamp: float, world: World = BOX) -> DepthFrame:
    """The box at the border of an image that is hardly wider than the hand."""
    oTc = looking_down(0.26)
    oTc.translation[1] += 0.1
    return replace(frame(world, oTc), stamp=stamp)


def across(
    detector: GraspDetector, seen: DepthFrame, memory: SceneMemory | None = None
) -> list[GraspEstimate]:
    """The grasps that are likely to hold; one on a corner of the box is not."""
    return [one for one in detector.detect(seen, WORKSPACE, memory).grasps if one.quality > 0.7]


def from_both(shift: float) -> tuple[HeightMap, HeightMap]:
    """What is seen from near and, `shift` beside it, from afar."""
    far = looking_down(0.5)
    far.translation[1] += shift
    return seen_from(looking_down(0.26)), seen_from(far)


def test_where_the_newest_map_shows_nothing_it_is_the_earlier_one() -> None:
    near, far = from_both(shift=-0.0123)
    both = completed(near, [far])
    assert near.unknown is not None
    row, column = np.nonzero(~near.unknown)
    x, y = near.origin[0] + near.cell * column, near.origin[1] + near.cell * row
    np.testing.assert_array_equal(both.at(x, y), near.heights[row, column])
    x, y = np.full(60, 3.0), near.origin[1] - near.cell * np.arange(60)
    assert unknown_at(near, 3.0, y[-1])
    assert not unknown_at(both, 3.0, y[-1])
    np.testing.assert_array_equal(both.at(x, y), far.at(x, y))


def test_what_was_seen_there_is_in_the_way(detector: GraspDetector) -> None:
    """A post beside the box, which the image from near does not show."""
    post = Geom(Box((0.1, 0.012, 0.09)), SE3(np.eye(3), np.array([3.0, -0.062, 0.546])), "post")
    world = World([*BOX.fixtures, post], BOX.objects)
    memory = SceneMemory()
    detector.detect(from_afar(0.0, world), WORKSPACE, memory)
    assert not across(detector, from_near(1.0, world), memory)


def test_what_moves_is_forgotten_where_it_was_and_what_stands_still_is_not() -> None:
    """The box was seen at y = 0, and has come to y = 0.1 since."""
    memory = SceneMemory()
    memory.completed(seen_from(looking_down(0.5)), 1.0)
    oTg = SE3(np.diag([1.0, -1.0, -1.0]), np.array([3.0, 0.1, FLOOR + 0.02]))
    moved = replace(grasp(0.0, 0.0), oTg=oTg, stamp=2.0, velocity=np.array([0.0, 0.1, 0.0]))
    left = memory.without(moved, FLOOR)
    blind = seen_from(looking_down(0.5))
    blind = replace(blind, unknown=np.ones_like(blind.unknown))
    before, after = memory.completed(blind, 2.0), left.completed(blind, 2.0)
    assert not unknown_at(before, 3.0, 0.0)
    assert unknown_at(after, 3.0, 0.0)
    assert not unknown_at(after, 3.0, 0.12)
    wall = 3.0 - 0.22 - 0.003
    assert unknown_at(before, wall, 0.0) == unknown_at(after, wall, 0.0)
