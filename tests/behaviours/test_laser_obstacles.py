"""What the laser sees is an obstacle where it was seen, wherever the map has the base."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from harness import Harness, table_world
from pinocchio import SE3, utils

from behaviours.sensing.laser_obstacles import LaserObstacles
from hw.state import LaserScan, LocalisedPose
from robots import Box, Geom

LEG = np.array([0.6, 0.2, 0.19])


def scan(wTb: SE3, rng: np.random.Generator) -> LaserScan:
    """Four beams that meet a leg, and one far away."""
    seen = LEG + rng.normal(size=(4, 3)) * [0.005, 0.005, 0.0]
    points = np.vstack([(seen - wTb.translation) @ wTb.rotation, [[3.0, 0.0, 0.19]]])
    ranges = np.linalg.norm(points, axis=1)
    return LaserScan(stamp=0.0, ranges=ranges, points=points, oTb=wTb)


def test_a_leg_is_where_it_was_seen_though_the_base_turned():
    rng, seen = np.random.default_rng(0), LaserObstacles()
    for turn in (0.0, 0.2, 0.4):
        seen.look(scan(SE3(utils.rotate("z", turn), np.array([0.1, 0.0, 0.0])), rng), [])
    assert len(seen.points)
    assert np.linalg.norm(seen.points - LEG, axis=1).max() < 0.03


def test_a_person_is_no_laser_obstacle():
    person = Geom(Box((0.1, 0.1, 1.0)), SE3(np.eye(3), LEG), "person")
    seen = LaserObstacles()
    seen.look(scan(SE3.Identity(), np.random.default_rng(0)), [person])
    assert not len(seen.points)


@pytest.mark.parametrize("localised", [True, False])
def test_laser_points_are_obstacles_on_a_map_that_may_be_wrong(localised, monkeypatch):
    harness, rng = Harness(table_world()), np.random.default_rng(0)
    laser = SimpleNamespace(latest=lambda age: scan(SE3.Identity(), rng))
    monkeypatch.setattr(type(harness.robot), "laser", laser)
    off = SE3(np.eye(3), np.array([0.05, 0.0, 0.0]))
    for _ in range(3):
        state = harness.robot.read()
        pose = LocalisedPose(stamp=0.0, mTb=off * state.wTb, covariance=1e-4 * np.eye(3))
        harness.context.begin_tick(replace(state, localised=pose if localised else None))
    points = harness.context.surroundings.depth_points
    assert (points is not None) is localised
    if points is not None:
        assert np.linalg.norm(points.points - off.act(LEG), axis=1).max() < 0.03
