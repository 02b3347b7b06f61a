"""Stereo depth: smoothing, holes and their causes, the border, and the hand beside them."""

import numpy as np
import pytest
from pinocchio import SE3
from test_detector import CAMERA, FLOOR, GRIPPER, box_world, frame, looking_down

from hw.sim import World
from perception.grasps.feasibility import assess
from perception.grasps.height_map import HeightMap, local_heights
from perception.grasps.network_input import scaled_crop
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
    return float(unknown_pixels(depth, missing, FX, 0.6)[missing].mean())


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


def seen_from(wTc: SE3, hole: int = 0) -> HeightMap:
    """A box on a wide floor, with a square hole of so many pixels in the middle of the image."""
    floor = Geom(Box((2.0, 2.0, 0.1)), SE3(np.eye(3), np.array([3.0, 0.0, FLOOR - 0.1])), "floor")
    world = World([floor], box_world(yaw=0.0, x=3.0, y=0.0).objects)
    seen = frame(world, wTc)
    depth = np.array(seen.depth)
    rows, columns = (slice(n // 2 - hole // 2, n // 2 + hole // 2) for n in depth.shape)
    depth[rows, columns] = np.nan
    support = float((FLOOR - wTc.translation[2]) / wTc.rotation[2, 2])
    return local_heights(seen, depth, scaled_crop(depth.shape, CAMERA, support), support).scene


def unknown_at(found: HeightMap, x: float, y: float) -> bool:
    assert found.unknown is not None
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
    assert unknown is not None
    assert all(edge.all() for edge in (unknown[0], unknown[-1], unknown[:, 0], unknown[:, -1]))


def beside_a_column(height: float) -> tuple[HeightMap, float]:
    """What a camera 0.3 m above the floor sees of it, and the score of a grasp 70 mm beside it."""
    floor = Geom(Box((2.0, 2.0, 0.1)), SE3(np.eye(3), np.array([3.0, 0.0, FLOOR - 0.1])), "floor")
    sizes = {(3.0, 0.0): (0.02, 0.02, 0.035), (3.0, 0.07): (0.02, 0.01, 0.5 * height)}
    boxes = [
        Geom(Box(half), SE3(np.eye(3), np.array([x, y, FLOOR + half[2]])), "box")
        for (x, y), half in sizes.items()
    ]
    wTc = looking_down(0.3)
    wTc.translation[1] -= 0.02  # so that the side of the column is seen
    seen = frame(World([floor, *boxes], []), wTc)
    around = local_heights(seen, np.array(seen.depth), scaled_crop((480, 640), CAMERA, 0.3), 0.3)
    at = 3.0 * np.ones(1), np.zeros(1), 0.5 * np.pi * np.ones(1)
    return around.scene, float(assess(around.scene, *at, FLOOR, GRIPPER).score[0])


def test_the_palm_does_not_meet_what_is_within_the_minimum_range() -> None:
    low, fits = beside_a_column(0.09)
    assert low.rising is None
    assert fits > 0.0
    tall, score = beside_a_column(0.24)
    assert tall.rising is not None
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


def test_smoothing_improves_far_surfaces_and_keeps_edges() -> None:
    true, measured = step(1.5, 1.5, noise=0.1)
    before, after = (np.std(depth - true) for depth in (measured, smoothed(measured, FX)))
    assert before == pytest.approx(0.0113, rel=0.1)
    assert after < before / 3
    true, measured = step(1.35, 1.5, noise=0.05)
    edge = 0.5 * (1.35 + 1.5)
    assert np.mean((smoothed(measured, FX) < edge) == (true < edge)) > 0.999
