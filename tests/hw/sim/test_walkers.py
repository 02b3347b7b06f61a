"""Walkers, and the free ways of the scenes that have them."""

from itertools import pairwise

import numpy as np
import pytest
from pinocchio import SE3

from hw import WorldOptions, open_backend
from hw.sim import Walker, load_scene
from hw.sim.contact import separation
from robots import Cylinder, Geom

TURNING = 0.43  # half the diagonal of the base [m]
HEADROOM = 1.2  # height of the folded arm [m]


def test_a_walker_keeps_its_speed_between_the_ends_and_turns_round_smoothly():
    walker = Walker("Ada", 0.25, 1.75, [(0.0, 0.0), (3.0, 0.0)], 1.0)
    times = np.arange(0.0, 7.0, 0.01)
    places, speeds = [], []
    for time in times:
        walker.move_to(time)
        places.append(walker.pose.translation)
        speeds.append(walker.velocity)
    x, v = np.array(places)[:, 0], np.array(speeds)[:, 0]
    np.testing.assert_allclose(np.gradient(x, 0.01)[1:-1], v[1:-1], atol=0.011)
    assert np.abs(np.diff(v)).max() <= 2.0 * 0.01 + 1e-9
    np.testing.assert_allclose(np.abs(v[(x > 0.3) & (x < 2.7)]), 1.0)
    assert x.max() == pytest.approx(3.0, abs=1e-3)
    assert x[700 - 1] == pytest.approx(0.0, abs=1e-3)  # 3.5 s there, 3.5 s back
    assert {tuple(place[1:]) for place in places} == {(0.0, 0.875)}


def test_the_world_tells_where_walkers_are_and_how_fast_as_a_tracker_would():
    backend = open_backend("frankie", "kinematic", WorldOptions(scene="crossing"))
    for _ in range(100):
        backend.robot.read()
        backend.clock.sleep_until(backend.clock.now() + 0.01)
    backend.robot.read()
    (obstacle,) = backend.truth.moving()
    assert obstacle.geom.name == "person"
    assert obstacle.geom.shape == Cylinder(0.25, 0.875)
    np.testing.assert_allclose(obstacle.velocity, [0.0, 1.0, 0.0])
    np.testing.assert_allclose(obstacle.geom.pose.translation, [1.3, -2.5 + 0.75, 0.875])


@pytest.mark.parametrize(
    ("scene", "x"), [("household", 0.0), ("corridor", 0.0), ("crossing", 0.0), ("kitchen", 0.2)]
)
def test_a_robot_can_drive_from_the_container_to_the_table_and_turn_anywhere(scene, x):
    world = load_scene(scene, 0)
    obstacles = [f for f in world.fixtures if f.name != "floor"]
    for start, end in pairwise([(2.25, 0.0), (x, 0.0), (x, 0.85)]):
        for x, y in np.linspace(start, end, 30):
            room = SE3(np.eye(3), np.array([x, y, HEADROOM / 2.0]))
            round_it = Geom(Cylinder(TURNING, HEADROOM / 2.0 - 0.01), room)
            assert min(separation(round_it, other)[0] for other in obstacles) > 0.0
