"""Convex hulls and meshes: depth images, measures and contacts."""

import numpy as np
import pytest
from pinocchio import SE3, exp3

from controller.floor.footprints import footprint
from hw.sim import DepthRenderer
from hw.sim.contact import patch, separation, travel
from hw.sim.sim_object import Mesh, Surface
from robots import (
    Box,
    Geom,
    Intrinsics,
    Plane,
    bounding_radius,
    centroid,
    half_extents,
    hull_of,
    reach,
    volume,
)

CAMERA = Intrinsics(width=100, height=75, fx=60.0, fy=62.0, cx=47.3, cy=38.1)
HALF = (0.05, 0.08, 0.03)
CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * HALF


def test_no_ray_slips_through_the_edges_of_a_fine_mesh():
    ways = np.random.default_rng(1).normal(size=(4000, 3))
    ball = hull_of(0.1 * ways / np.linalg.norm(ways, axis=1, keepdims=True))
    mesh = Mesh(ball.shape.vertices, ball.shape.triangles)
    pose = SE3(np.eye(3), np.array([0.0, 0.0, 0.3]))
    image = DepthRenderer(CAMERA).render([Surface(mesh, pose)], SE3.Identity())
    rows, columns = np.nonzero(np.isfinite(image))
    for row in np.unique(rows):  # a ball has no gaps in any row
        inside = columns[rows == row]
        assert len(inside) == np.ptp(inside) + 1


def test_only_an_open_mesh_is_seen_from_inside():
    box = hull_of(CORNERS).shape
    for closed, seen in ((True, False), (False, True)):
        around = Surface(Mesh(box.vertices, box.triangles, closed), SE3.Identity())
        image = DepthRenderer(CAMERA).render([around], SE3.Identity())
        assert np.isfinite(image).all() == seen


def test_a_hull_measures_as_the_box_with_its_corners():
    placed = hull_of(CORNERS + np.array([0.2, -0.1, 0.4]))
    box, hull = Box(HALF), placed.shape
    np.testing.assert_allclose(placed.pose.translation, [0.2, -0.1, 0.4])
    np.testing.assert_allclose(half_extents(hull), half_extents(box))
    np.testing.assert_allclose(centroid(hull), 0.0, atol=1e-12)
    assert volume(hull) == pytest.approx(volume(box))
    assert bounding_radius(hull) == pytest.approx(bounding_radius(box))
    pose = SE3(exp3(np.array([0.3, -0.8, 1.1])), np.array([0.1, 0.2, 0.5]))
    for way in np.random.default_rng(0).normal(size=(5, 3)):
        assert reach(Geom(hull, pose), way) == pytest.approx(reach(Geom(box, pose), way))
    one, other = footprint(Geom(hull, pose), 0.45, 0.52), footprint(Geom(box, pose), 0.45, 0.52)
    x, y = np.random.default_rng(0).uniform(-0.2, 0.4, (2, 50))
    np.testing.assert_allclose(one.distances(x, y), other.distances(x, y), atol=1e-9)
    assert footprint(Geom(hull, pose), 0.7, 0.8) is None
    turns = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    ring = np.stack([np.cos(turns), np.sin(turns), 0.0 * turns], axis=1)
    cone = hull_of(np.vstack([ring, [0.0, 0.0, 1.0]]))
    np.testing.assert_allclose(cone.pose.act(centroid(cone.shape)), [0.0, 0.0, 0.25], atol=1e-6)
    with pytest.raises(ValueError, match="no volume"):
        hull_of(CORNERS * [1.0, 1.0, 0.0])


def test_a_hull_touches_as_the_box_with_its_corners():
    pose = SE3(exp3(np.array([0.3, -0.8, 1.1])), np.array([0.02, 0.01, 0.3]))
    floor, box, hull = Geom(Plane(), SE3.Identity()), Geom(Box(HALF), pose), hull_of(CORNERS)
    placed = hull.moved(pose)
    down = np.array([0.0, 0.0, -1.0])
    assert separation(placed, floor)[0] == pytest.approx(separation(box, floor)[0], abs=1e-6)
    fall = travel(placed, down, [floor], 1.0)
    assert fall == pytest.approx(travel(box, down, [floor], 1.0), abs=1e-4)
    lying = hull.moved(SE3(np.eye(3), np.array([0.0, 0.0, HALF[2] - 5e-4])))
    found = patch(lying, Geom(Box((0.5, 0.5, 0.1)), SE3(np.eye(3), np.array([0.0, 0.0, -0.1]))))
    points, normal = found
    np.testing.assert_allclose(np.abs(points[:, :2]).max(axis=0), HALF[:2], atol=1e-3)
    np.testing.assert_allclose(normal, down, atol=1e-6)
