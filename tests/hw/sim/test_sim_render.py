"""Depth images against sphere tracing on signed distances, in float64."""

import numpy as np
import pytest
from pinocchio import SE3, exp3

from hw.sim import DepthRenderer
from hw.sim.camera.render import NEAR
from robots import Box, Capsule, Cylinder, Geom, Hull, Intrinsics, Plane, Sphere, hull_of

CAMERA = Intrinsics(width=100, height=75, fx=60.0, fy=62.0, cx=47.3, cy=38.1)
PEBBLE = hull_of(0.03 * np.random.default_rng(0).normal(size=(20, 3))).shape
SHAPES = [Box((0.05, 0.08, 0.03)), Sphere(0.07), Cylinder(0.04, 0.09), Capsule(0.03, 0.08), PEBBLE]


def signed_distance(shape: object, p: np.ndarray) -> np.ndarray:
    """Of (N, 3) points in the shape's frame; of a hull at most that."""
    radial = np.hypot(p[:, 0], p[:, 1])
    match shape:
        case Plane():
            return p[:, 2]
        case Sphere(r):
            return np.linalg.norm(p, axis=1) - r
        case Hull(vertices, triangles):
            a, b, c = vertices[triangles].transpose(1, 0, 2)
            normals = np.cross(b - a, c - a)
            normals /= np.linalg.norm(normals, axis=1, keepdims=True)
            return (p @ normals.T - np.einsum("ij,ij->i", normals, a)).max(axis=1)
        case Capsule(r, length):
            ends = np.clip(p[:, 2], -length, length)
            return np.hypot(radial, p[:, 2] - ends) - r
        case Cylinder(r, length):
            q = np.stack([radial - r, np.abs(p[:, 2]) - length], axis=1)
        case Box(half):
            q = np.abs(p) - half
    outside = np.linalg.norm(np.maximum(q, 0.0), axis=1)
    return outside + np.minimum(q.max(axis=1), 0.0)


def rays() -> np.ndarray:
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width].reshape(2, -1)
    x, y = (u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy
    return np.stack([x, y, np.ones_like(x)], axis=1)


def traced(placed: Geom, wTc: SE3) -> tuple[np.ndarray, np.ndarray]:
    """Depth (inf where missed) and whether the ray only just hits or misses, for each pixel."""
    sTc = placed.pose.actInv(wTc)
    directions = rays()
    stretch = np.linalg.norm(directions, axis=1)
    along = directions @ sTc.rotation.T
    depth, nearest = np.zeros(len(along)), np.full(len(along), np.inf)
    for _ in range(200):
        gap = signed_distance(placed.shape, sTc.translation + depth[:, None] * along)
        nearest = np.minimum(nearest, gap)
        depth += np.maximum(gap, 0.0) / stretch
        depth = np.minimum(depth, 100.0)
    hit = nearest < 1e-6
    doubtful = (nearest > 1e-7) & (nearest < 2e-4)
    clipped = hit & (depth <= NEAR)
    return np.where(hit & ~clipped, depth, np.inf), doubtful


def compare(shapes: list[Geom], wTc: SE3) -> np.ndarray:
    """Check an image against the truth; returns the image."""
    image, ids = DepthRenderer(CAMERA).render_with_ids(shapes, wTc)
    assert image.shape == ids.shape == (CAMERA.height, CAMERA.width)
    assert image.dtype == np.float32
    every, doubtful = zip(*(traced(s, wTc) for s in shapes), strict=True)
    truth = np.min(every, axis=0)
    sure = ~np.any(doubtful, axis=0)
    assert sure.mean() > 0.9
    rendered = np.where(np.isnan(image), np.inf, image).ravel()
    assert np.array_equal(np.isinf(rendered)[sure], np.isinf(truth)[sure])
    seen = sure & np.isfinite(truth)
    np.testing.assert_allclose(rendered[seen], truth[seen], rtol=2e-5, atol=2e-5)
    assert (ids.ravel()[np.isnan(image.ravel())] == -1).all()
    shown = np.take_along_axis(np.array(every), np.maximum(ids.ravel(), 0)[None], axis=0)[0]
    np.testing.assert_allclose(shown[seen], truth[seen], rtol=2e-5, atol=2e-5)
    return image


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
@pytest.mark.parametrize("seed", range(2))
def test_a_shape_anywhere_in_front_of_the_camera(shape, seed):
    rng = np.random.default_rng(seed)
    turn, where = exp3(rng.normal(size=3)), rng.uniform([-0.2, -0.1, 0.25], [0.2, 0.1, 0.6])
    wTc = SE3(exp3(rng.normal(size=3)), rng.normal(size=3))
    image = compare([Geom(shape, wTc * SE3(turn, where))], wTc)
    assert np.isfinite(image).sum() > 20


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
@pytest.mark.parametrize("seed", range(2))
def test_a_shape_on_both_sides_of_the_image_plane(shape, seed):
    """Such as a finger or the wall that the camera passes by."""
    rng = np.random.default_rng(seed)
    turn = exp3(rng.normal(size=3))
    side = rng.normal(size=2)
    where = np.array([*(0.1 * side / np.linalg.norm(side)), rng.uniform(-0.02, 0.06)])
    if signed_distance(shape, -(where[None] @ turn))[0] < 0.002:
        pytest.skip("the camera is inside")
    compare([Geom(shape, SE3(turn, where))], SE3.Identity())


def test_the_floor_reaches_to_the_horizon_and_is_not_visible_from_below():
    level = SE3(
        np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]), np.array([0, 0, 1.0])
    )
    image = DepthRenderer(CAMERA).render([Geom(Plane(), SE3.Identity())], level)
    rows = np.arange(CAMERA.height)
    below = rows > CAMERA.cy
    expected = CAMERA.fy / (rows[below] - CAMERA.cy)
    np.testing.assert_allclose(image[below], np.tile(expected[:, None], CAMERA.width), rtol=1e-5)
    assert np.isnan(image[~below]).all()
    under = SE3(np.eye(3), np.array([0.0, 0.0, -0.5]))
    assert np.isnan(DepthRenderer(CAMERA).render([Geom(Plane(), SE3.Identity())], under)).all()


def test_a_crowd_shows_the_nearest_surface_everywhere():
    rng = np.random.default_rng(5)
    crowd = [Geom(Plane(), SE3.Identity())]
    for index in range(10):
        where = np.array([*rng.uniform(-0.3, 0.3, 2), rng.uniform(0.0, 0.2)])
        crowd.append(Geom(SHAPES[index % 5], SE3(exp3(rng.normal(size=3)), where)))
    look_down = SE3(
        exp3(np.array([0.1, -0.2, 0.3])) @ np.diag([1.0, -1.0, -1.0]), np.array([0, 0, 0.7])
    )
    compare(crowd, look_down)


def test_strips_of_a_large_image_meet_without_a_seam():
    large = Intrinsics(width=40, height=400, fx=200.0, fy=200.0, cx=20.0, cy=200.0)
    ball = [Geom(Sphere(0.3), SE3(np.eye(3), np.array([0.0, 0.0, 0.8])))]
    column = DepthRenderer(large).render(ball, SE3.Identity())[:, 20].astype(float)
    y = (np.arange(400) - 200.0) / 200.0
    a, b, c = 1.0 + y * y, -0.8, 0.8**2 - 0.3**2
    with np.errstate(invalid="ignore"):
        expected = (-b - np.sqrt(b * b - a * c)) / a
    np.testing.assert_allclose(column, expected, rtol=1e-4)
