"""Distances that are kept from step to step are those that are measured anew."""

import numpy as np
import pytest
from motion import proximity
from pinocchio import SE3

from controller import Obstacle, PointCloud, Surroundings, robot_model
from controller.collision.proximity import Distances
from robots import Box, Cylinder, Geom

TABLE = (
    Geom(Box((0.3, 0.5, 0.02)), SE3(np.eye(3), np.array([1.2, 0.0, 0.5])), "table/top"),
    Geom(Cylinder(0.05, 0.25), SE3(np.eye(3), np.array([0.9, 0.4, 0.25])), "table/leg"),
)
ROD = (Geom(Box((0.02, 0.02, 0.15)), SE3(np.eye(3), np.array([0.0, 0.0, 0.12])), "held"),)
CAN = (Geom(Cylinder(0.03, 0.05), SE3(np.eye(3), np.array([1.0, 0.0, 0.57])), "can"),)


@pytest.fixture(params=["frankie", "omni"])
def model(request):
    return robot_model(request.param)


def walker(step: int) -> Obstacle:
    centre = np.array([2.5 - 0.01 * step, 0.0, 0.85])
    geom = Geom(Cylinder(0.25, 0.85), SE3(np.eye(3), centre), "walker")
    return Obstacle(geom, np.array([-1.0, 0.0, 0.0]))


CLOUDS = tuple(
    PointCloud(np.random.default_rng(seed).uniform([-0.6, -0.8, 0.45], [1.2, 0.8, 1.4], (300, 3)))
    for seed in (1, 2)
)
"""Points beside, before and above the base, in two pictures."""


def assert_same(ours: Distances, fresh: Distances) -> None:
    """As exactly as Coal measures, which begins where it ended the last time."""
    np.testing.assert_array_equal(ours.pair, fresh.pair)
    np.testing.assert_allclose(ours.d, fresh.d, atol=1e-5)
    np.testing.assert_allclose(ours.rows, fresh.rows, atol=1e-2)


@pytest.mark.parametrize(("walked", "sees"), [(False, False), (True, False), (False, True)])
def test_what_is_picked_up_and_put_down_leaves_the_other_distances(model, walked, sees):
    kept, q = proximity(model), model.description.arm.ready.copy()
    slow, seen = np.full(model.n, 0.2), 0
    for step in range(90):
        wTb = SE3(np.eye(3), np.array([0.004 * step, 0.0, 0.0]))
        q[0] += 0.01
        known = Surroundings(
            fixtures=TABLE,
            held=ROD if 30 <= step < 60 else (),
            loose=CAN if step >= 60 else (),
            depth_points=CLOUDS[step >= 30] if sees else None,
            moving=(walker(step),) if walked else (),
        )
        ours, fresh = (p.near(wTb, q, known, slow) for p in (kept, proximity(model)))
        assert_same(ours, fresh)
        seen += len(ours.d)
    assert seen > 200
