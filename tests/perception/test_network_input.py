"""Network input and output maps, on images with known answers."""

import numpy as np
import pytest
from pinocchio import SE3, exp3

from perception import DepthCloud
from perception.grasps.network_input import (
    METRES_PER_PIXEL,
    WIDTH_SCALE,
    Crop,
    fill,
    prepare,
    scaled_crop,
)
from perception.networks.output_maps import find_candidates, grasp_maps
from robots import Intrinsics

CAMERA = Intrinsics(width=640, height=480, fx=383.0, fy=383.0, cx=319.5, cy=239.5)
DOWN = np.diag([1.0, -1.0, -1.0])
ALL = np.ones((100, 100), dtype=np.bool_)


def cloud(depth: np.ndarray, oTc: SE3) -> DepthCloud:
    return DepthCloud(depth=depth, intrinsics=CAMERA, oTc=oTc)


@pytest.mark.parametrize("depth", [0.01, 0.36, 0.6, 100.0])
def test_the_crop_is_inside_the_image_and_of_constant_scale_where_it_can_be(depth: float) -> None:
    crop = scaled_crop((480, 640), CAMERA, depth)
    assert min(crop.u0, crop.v0) >= 0
    assert crop.u0 + crop.size <= 640
    assert crop.v0 + crop.size <= 480
    assert crop.u0 + crop.size / 2 == pytest.approx(320, abs=1)
    if 0.3 < depth < 1.0:
        assert crop.scale * depth / CAMERA.fx == pytest.approx(METRES_PER_PIXEL, rel=0.01)


def to_input(crop: Crop, u: float, v: float) -> np.ndarray:
    """The input pixel (u, v) that shows a pixel of the full image."""
    pixel = (np.array([u, v]) - [crop.u0, crop.v0] + 0.5) / crop.scale - 0.5
    assert crop.to_image(pixel) == pytest.approx([u, v])
    return np.rint(pixel).astype(int)


def test_a_shadow_beside_an_object_is_filled_with_the_background() -> None:
    depth = np.full((4, 20), 0.5, dtype=np.float32)
    depth[:, 10:15] = 0.4
    missing = np.zeros(depth.shape, dtype=np.bool_)
    missing[:, 6:10] = True
    missing[2] = True
    depth[missing] = np.nan
    filled = fill(depth, missing)
    assert (filled[:, 6:10] == np.float32(0.5)).all()
    assert (filled[:, 10:15] == np.float32(0.4)).all()
    assert np.isfinite(filled).all()


def test_preparing_keeps_depth_marks_holes_and_takes_the_mean_away() -> None:
    depth = np.full((480, 640), 0.45, dtype=np.float32)
    depth[200:280, 300:340] = 0.40
    depth[100:140, 240:280] = np.nan
    depth[150:160, 240:280] = 0.0
    crop = scaled_crop(depth.shape, CAMERA, 0.45)
    prepared = prepare(cloud(depth, SE3(DOWN, np.zeros(3))), crop)
    u, v = to_input(crop, 320.0, 240.0)
    assert prepared.depth[v, u] == pytest.approx(0.40)
    u, v = to_input(crop, 260.0, 120.0)
    assert prepared.missing[v, u]
    assert prepared.depth[v, u] == pytest.approx(0.45)
    assert prepared.missing.sum() == pytest.approx(50 * 40 / crop.scale**2, rel=0.1)
    assert abs(float(prepared.network_input.mean())) < 1e-5
    assert np.ptp(prepared.network_input) == pytest.approx(0.05, rel=1e-4)


def _maps(u: float, v: float, angle: float, width: float) -> np.ndarray:
    """Maps with one ridge: best at (u, v), closing along `angle` (from u towards v)."""
    rows, columns = 3.0 * np.mgrid[0:100, 0:100] + 1.0
    maps = np.zeros((4, 100, 100), dtype=np.float32)
    along = (columns - u) * np.cos(angle) + (rows - v) * np.sin(angle)
    across = -(columns - u) * np.sin(angle) + (rows - v) * np.cos(angle)
    maps[0] = np.exp(-0.5 * (along / 4.0) ** 2 - 0.5 * (across / 15.0) ** 2)
    maps[1] = np.cos(2.0 * -angle)
    maps[2] = np.sin(2.0 * -angle)
    maps[3] = width / WIDTH_SCALE
    return maps


@pytest.mark.parametrize("angle_deg", [-80, 0, 89])
def test_a_ridge_is_found_to_less_than_a_cell(angle_deg: float) -> None:
    angle = np.deg2rad(angle_deg)
    rng = np.random.default_rng(0)
    maps = _maps(120.3, 200.7, angle, 27.0)
    maps[:3] += rng.normal(0.0, 0.015, maps[:3].shape).astype(np.float32)
    found = find_candidates(grasp_maps(maps, ALL))
    assert found.pixel[0] == pytest.approx([120.3, 200.7], abs=2.0)
    turn = (found.angle[0] - angle + np.pi / 2) % np.pi - np.pi / 2
    assert abs(np.rad2deg(turn)) < 5.0
    assert found.width[0] == pytest.approx(27.0, abs=0.5)


def test_a_tilted_camera_gives_a_level_image() -> None:
    """A table seen from the side is as flat for the network as one seen from above."""
    rotation = exp3(np.array([0.3, -0.2, 0.0])) @ DOWN
    v, u = np.mgrid[0:480, 0:640].astype(float)
    ray = np.stack([(u - 319.5) / 383.0, (v - 239.5) / 383.0, np.ones_like(u)], -1) @ rotation.T
    depth = (-0.5 / ray[..., 2]).astype(np.float32)
    crop = scaled_crop(depth.shape, CAMERA, 0.5)
    prepared = prepare(cloud(depth, SE3(rotation, np.array([1.0, 2.0, 3.0]))), crop)
    assert np.ptp(prepared.depth) > 0.1
    assert prepared.below == pytest.approx(0.5, abs=2e-3)
    assert np.abs(prepared.network_input).max() < 2e-3
