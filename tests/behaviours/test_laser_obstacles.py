"""What the laser sees is an obstacle where it was seen, wherever the map has the base."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from harness import Harness, table_world
from pinocchio import SE3, utils

from behaviours.sensing.laser_obstacles import LaserObstacles, Scans
from hw.state import LaserScan, LocalisedPose
from robots import Box, Geom

LEG = np.array([0.6, 0.2, 0.19])


def scan(oTb: SE3, rng: np.random.Generator) -> LaserScan:
    """Four beams that meet a leg, and one far away."""
    seen = LEG + rng.normal(size=(4, 3)) * [0.005, 0.005, 0.0]
    points = np.vstack([(seen - oTb.translation) @ oTb.rotation, [[3.0, 0.0, 0.19]]])
    ranges = np.linalg.norm(points, axis=1)
    return LaserScan(stamp=0.0, ranges=ranges, points=points, oTb=oTb)


@pytest.mark.parametrize(("noise", "way"), [(0.0, 0.0), (0.0, 0.2), (0.005, 0.0)])
def test_a_scan_that_repeats_itself_is_believed_only_where_nothing_should_change_it(noise, way):
    scans, rng = Scans(), np.random.default_rng(0)
    dark, ranges = np.full(50, np.nan), np.full(50, 2.0)

    def is_believed(stamp: float, x: float = 0.0) -> bool:
        oTb = SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        new = LaserScan(stamp=stamp, ranges=ranges.copy(), points=np.zeros((50, 3)), oTb=oTb)
        return scans.newest(SimpleNamespace(latest=lambda age: new)) is new

    for k in range(5):
        ranges += noise * rng.normal(size=50)
        assert is_believed(0.1 * k)
    repeats = [is_believed(0.5 + 0.1 * k, x=way * k) for k in range(6)]
    assert repeats == [True] * 6 if noise == way == 0.0 else repeats[-1] is False
    assert repeats[0]
    assert ("the laser hangs" in scans.mistake) is (not repeats[-1])
    ranges = dark  # nothing in reach looks the same for ever
    assert all(is_believed(1.1 + 0.1 * k, x=way * k) for k in range(6))


def test_a_leg_is_where_it_was_seen_though_the_base_turned_and_a_person_is_nowhere():
    person = Geom(Box((0.1, 0.1, 1.0)), SE3(np.eye(3), LEG), "person")
    for around, seen in (([], LaserObstacles()), ([person], LaserObstacles())):
        rng = np.random.default_rng(0)
        for turn in (0.0, 0.2, 0.4):
            seen.look(scan(SE3(utils.rotate("z", turn), np.array([0.1, 0.0, 0.0])), rng), around)
        assert bool(len(seen.points)) is not bool(around)
        assert (np.linalg.norm(seen.points - LEG, axis=1) < 0.03).all()


@pytest.mark.parametrize("localised", [True, False])
def test_laser_points_are_obstacles_on_a_map_that_may_be_wrong(localised, monkeypatch):
    harness, rng = Harness(table_world()), np.random.default_rng(0)
    laser = SimpleNamespace(latest=lambda age: scan(SE3.Identity(), rng))
    monkeypatch.setattr(type(harness.robot), "laser", laser)
    off = SE3(np.eye(3), np.array([0.05, 0.0, 0.0]))
    for _ in range(3):
        state = harness.robot.read()
        pose = LocalisedPose(stamp=0.0, mTb=off * state.oTb, covariance=1e-4 * np.eye(3))
        harness.context.begin_tick(replace(state, localised=pose if localised else None))
    points = harness.context.surroundings.depth_points
    assert (points is not None) is localised
    if points is not None:
        assert np.linalg.norm(points.points - off.act(LEG), axis=1).max() < 0.03
