"""Distances to seen points are those of the robot's shapes, and grow as the rows say."""

import numpy as np
import pinocchio as pin
import pytest
from motion import proximity
from pinocchio import SE3

from controller import PointCloud, Surroundings, robot_model
from controller.collision.collision_model import PairKind
from robots import Box, Capsule, Geom, Sphere, from_rounded_boxes, rounded_box


@pytest.fixture(params=["frankie", "omni"])
def model(request):
    return robot_model(request.param)


def around(seed: int, count: int = 300) -> np.ndarray:
    """Points beside, before and above the base."""
    return np.random.default_rng(seed).uniform([-0.6, -0.8, 0.45], [1.2, 0.8, 1.4], (count, 3))


def near(model, q, wTb=None, **known):
    fastest = np.abs(model.velocity_limits).max(axis=0)
    return proximity(model).near(wTb or SE3.Identity(), q, Surroundings(**known), fastest)


def by_name(model, known) -> dict[str, np.ndarray]:
    """The distances of each part of the robot to what stands around, by its name."""
    prox, q = proximity(model), model.description.arm.ready
    found = prox.near(SE3.Identity(), q, known, np.abs(model.velocity_limits).max(axis=0))
    found = found.without(PairKind.SELF)
    names = np.array([prox.pair_name(int(pair)).split(" and ")[0] for pair in found.pair])
    return {name: found.d[names == name] for name in set(names)}


def test_points_are_as_near_to_every_link_as_coal_says(model):
    points = around(0, 200)
    balls = tuple(Geom(Sphere(1e-5), SE3(np.eye(3), p), f"{k}") for k, p in enumerate(points))
    ours = by_name(model, Surroundings(depth_points=PointCloud(points)))
    coals = by_name(model, Surroundings(fixtures=balls))
    assert set(ours) >= {"base", "link1", "link3", "link5", "link7", "hand", "camera"}
    for name, distances in ours.items():
        measured = distances + 0.01  # what may stand between the points is taken off
        assert measured.min() < coals[name].min() + 0.01, name
        off = np.abs(measured[:, None] - coals[name]).min(axis=1)
        assert off.max() < 1e-4, name


def test_rows_are_the_rates_at_which_distances_grow(model):
    cloud, q = PointCloud(around(0)), model.description.arm.ready
    start, step = near(model, q, depth_points=cloud), 1e-6
    assert len(start.d) > 10
    for number in range(model.n):
        moved = np.zeros(model.n)
        moved[number] = step
        twist = model.command(moved).base_twist
        wTb = pin.exp6(np.array([twist[0], twist[1], 0.0, 0.0, 0.0, twist[2]]))
        after = near(model, q + moved[model.n_base :], wTb, depth_points=cloud)
        rates = (after.d - start.d) / step
        np.testing.assert_allclose(rates, start.rows[:, number], atol=1e-4)


def test_distances_from_rounded_boxes():
    points = np.array([[0.3, 0.0, 0.0], [0.0, 0.0, 0.5], [0.05, 0.0, 0.0], [0.2, 0.3, 0.0]])
    d, out = from_rounded_boxes(points, *rounded_box(Box((0.1, 0.2, 0.3))))
    np.testing.assert_allclose(d, [0.2, 0.2, -0.05, np.hypot(0.1, 0.1)])
    np.testing.assert_allclose(out[:3], [[1, 0, 0], [0, 0, 1], [1, 0, 0]])
    d, _ = from_rounded_boxes(points, *rounded_box(Capsule(0.1, 0.2)))
    np.testing.assert_allclose(d[:3], [0.2, 0.2, -0.05])
