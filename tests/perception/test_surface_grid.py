"""Surfaces in the grid are really there, and are cleared when they are gone."""

import numpy as np
import pinocchio as pin
import pytest
from pinocchio import SE3

from hw import DepthFrame
from hw.sim.camera.noise import D435Noise
from hw.sim.camera.render import DepthRenderer
from perception import SurfaceGrid, surface_cells
from perception.surface_grid import MEMORY
from robots import Box, Geom, Plane, from_rounded_boxes, load_robot, rounded_box

CAMERA = load_robot("frankie").camera
RENDERER = DepthRenderer(CAMERA.intrinsics)
FLOOR = Geom(Plane(), SE3.Identity(), "floor")


def box(centre, half) -> Geom:
    return Geom(Box(half), SE3(np.eye(3), np.array(centre, dtype=float)))


TABLE = box((1.0, 0.0, 0.25), (0.3, 0.5, 0.25))
POST = box((0.9, 0.1, 0.65), (0.03, 0.03, 0.15))


def looking(x, y, z, tilt=0.0) -> SE3:
    """From above, tilted forward."""
    return SE3(pin.rpy.rpyToMatrix(np.pi, tilt, -np.pi / 2), np.array([x, y, z]))


def frame(shapes, oTc, stamp=0.0) -> DepthFrame:
    depth = RENDERER.render(list(shapes), oTc)
    noise = D435Noise().apply(depth, CAMERA, np.random.default_rng(round(stamp * 1000)))
    return DepthFrame(depth=noise, intrinsics=CAMERA.intrinsics, oTc=oTc, stamp=stamp)


def see(surfaces, shapes, oTc, stamps) -> None:
    for stamp in stamps:
        one = frame(shapes, oTc, stamp)
        surfaces.update(one, surface_cells(one))


def distance(points, shapes) -> np.ndarray:
    """(N,) from points to the nearest surface [m]."""
    every = [
        from_rounded_boxes(points - one.pose.translation, *rounded_box(one.shape))[0]
        for one in shapes
    ]
    return np.abs(every).min(axis=0)


def of(points, shape) -> np.ndarray:
    return points[distance(points, [shape]) < 0.02]


@pytest.fixture
def surfaces() -> SurfaceGrid:
    return SurfaceGrid()


def test_noise_makes_no_ghosts(surfaces):
    """Flown over things in 3 s; a D435's noise, edges and holes included."""
    shapes = [FLOOR, TABLE, POST]
    for step in range(45):
        oTc = looking(0.4 + 0.01 * step, 0.2 * np.sin(0.1 * step), 1.2, 0.1)
        see(surfaces, shapes, oTc, [step / 15.0])
    points = surfaces.points
    assert len(points) > 500
    assert len(of(points, POST)) > 20
    off = distance(points, [TABLE, POST])
    assert (off > 0.03).mean() < 0.005
    assert off.max() < 0.06


def test_the_floor_and_one_frame_of_specks_are_no_obstacle(surfaces):
    see(surfaces, [FLOOR], looking(0.0, 0.0, 1.2, 0.3), np.arange(10) / 30.0)
    assert not len(surfaces.points)
    specks = frame([FLOOR], looking(0.0, 0.0, 1.2))
    specks.depth[np.random.default_rng(0).random(specks.depth.shape) < 0.02] = 0.5
    surfaces.update(specks, surface_cells(specks))
    assert not len(surfaces.points)


def test_what_was_taken_away_is_forgotten_once_its_place_is_seen(surfaces):
    oTc = looking(0.8, 0.0, 1.2)
    see(surfaces, [FLOOR, TABLE, POST], oTc, np.arange(5) / 10.0)
    assert len(of(surfaces.points, POST)) > 5
    see(surfaces, [FLOOR, TABLE], oTc, 0.5 + np.arange(8) / 10.0)
    assert surfaces.points[:, 2].max() < 0.56
    assert len(of(surfaces.points, TABLE)) > 300


def test_what_is_out_of_view_is_remembered_for_a_while_and_as_long_as_it_is_near(surfaces):
    see(surfaces, [FLOOR, TABLE, POST], looking(0.8, 0.0, 1.2), np.arange(5) / 10.0)
    away, beside = looking(-0.7, 0.0, 1.2), looking(-0.2, 0.0, 0.6)
    see(surfaces, [FLOOR], beside, [1.0, 1.0 + 3.0 * MEMORY])
    assert len(of(surfaces.points, POST)) > 5
    see(surfaces, [FLOOR], away, [2.0 + 3.0 * MEMORY])
    assert not len(surfaces.points)


def test_what_is_hidden_behind_something_is_not_forgotten(surfaces):
    oTc = looking(0.8, 0.0, 1.2)
    see(surfaces, [FLOOR, TABLE, POST], oTc, np.arange(5) / 10.0)
    count = len(of(surfaces.points, POST))
    lid = box((0.9, 0.1, 0.95), (0.25, 0.25, 0.01))
    see(surfaces, [FLOOR, TABLE, POST, lid], oTc, 0.5 + np.arange(10) / 10.0)
    assert len(of(surfaces.points, POST)) >= 0.9 * count
