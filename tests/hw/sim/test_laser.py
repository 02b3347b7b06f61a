"""Simulated laser: what it sees in both worlds, how well, and when."""

from math import inf

import numpy as np
import pinocchio as pin
import pytest
from harness import SIMULATORS, block, open_floor
from pinocchio import SE3
from solid_world import Solid

from hw import SimClock, WorldOptions, find_world, open_backend
from hw.sim import SimObject, Walker, World, simulated_robot
from hw.sim.contact import travel
from hw.sim.sim_laser import Solids
from robots import Box, Capsule, Cylinder, Geom, Plane, Sphere, hull_of, load_robot

LASER = load_robot("frankie").laser
FLOOR = Geom(Plane(), SE3.Identity(), "floor")
HIGH = LASER.bTs.translation[2]


def scattered(rng: np.random.Generator) -> list[Geom]:
    """Shapes of all kinds, anyhow turned, around the height of the laser."""
    shapes = [
        *(Box(tuple(rng.uniform(0.05, 0.3, 3))) for _ in range(4)),
        *(Cylinder(*rng.uniform(0.05, 0.3, 2)) for _ in range(4)),
        *(Capsule(*rng.uniform(0.05, 0.3, 2)) for _ in range(4)),
        *(Sphere(rng.uniform(0.05, 0.3)) for _ in range(4)),
        *(hull_of(rng.uniform(-0.3, 0.3, (12, 3))).shape for _ in range(4)),
    ]
    placed = []
    for number, shape in enumerate(rng.permutation(np.array(shapes, dtype=object))):
        bearing, far = 0.3 * number, rng.uniform(1.0, 4.0)
        place = np.array([far * np.cos(bearing), far * np.sin(bearing), rng.uniform(0.1, 0.3)])
        placed.append(Geom(shape, SE3(pin.exp3(rng.normal(size=3)), place)))
    return placed


def test_ranges_to_shapes_of_all_kinds_are_those_of_a_tiny_ball_that_moves_until_it_touches():
    shapes = scattered(np.random.default_rng(3))
    origin, beams = np.array([0.0, 0.0, HIGH]), LASER.beams
    seen = Solids([*shapes, FLOOR]).ranges(origin, beams)
    start = Geom(Sphere(1e-5), SE3(np.eye(3), origin))
    moved = [travel(start, beam, shapes, 10.0) for beam in beams]
    felt = np.array([inf if far is None else far for far in moved])
    both = np.isfinite(seen) & np.isfinite(felt)
    assert both.sum() > 100
    np.testing.assert_allclose(seen[both], felt[both], atol=5e-4)
    # The ball slides past what it would only graze.
    assert np.mean(np.isfinite(seen) != np.isfinite(felt)) < 0.03


def test_a_level_beam_along_a_face_or_an_axis_has_a_finite_answer():
    upright = Geom(Cylinder(0.2, 0.5), SE3(np.eye(3), np.array([2.0, 0.0, 0.3])))
    lying = Geom(Capsule(0.1, 0.5), SE3(pin.utils.rotate("y", np.pi / 2), np.array([0, 2.0, 0.2])))
    box = Geom(Box((0.1, 0.1, 0.1)), SE3(np.eye(3), np.array([-2.0, 0.0, 0.2])))
    beams = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    ranges = Solids([upright, lying, box]).ranges(np.array([0.0, 0.0, 0.2]), beams)
    np.testing.assert_allclose(ranges, [1.8, 1.9, 1.9, inf])


@pytest.mark.parametrize("world", SIMULATORS)
def test_it_sees_furniture_things_on_the_floor_and_people_but_not_the_robot(world):
    wall = Geom(Box((0.05, 5.0, 1.0)), SE3(np.eye(3), np.array([4.0, 0.0, 1.0])), "wall")
    shelf = Geom(Box((0.3, 0.3, 0.1)), SE3(np.eye(3), np.array([1.0, 0.0, 1.2])), "shelf")
    crate = SimObject(
        name="crate",
        parts=(Geom(Box((0.15, 0.15, 0.15)), SE3.Identity()),),
        mass=5.0,
        pose=SE3(np.eye(3), np.array([1.25, -1.0, 0.15])),
    )
    person = Walker("person", 0.25, 1.75, [(0.25, 2.0), (5.0, 2.0)], 1.0)
    sim = simulated_robot(
        find_world(world).body(),
        load_robot("frankie"),
        World([FLOOR, wall, shelf], [crate], [person]),
        SimClock(),
        seed=1,
    )
    with sim:
        sim.read()
        scan = sim.laser.latest(inf)
        ahead, left = scan.ranges[120], scan.ranges[210]
        crate_seen = scan.ranges[120 - 45]
        assert ahead == pytest.approx(3.7, abs=0.05)  # over the wall's front, below the shelf
        assert left == pytest.approx(1.75, abs=0.05)
        assert crate_seen == pytest.approx(0.85 * np.sqrt(2.0), abs=0.05)
        assert np.nanmin(scan.ranges) > 1.0
        assert scan.oTb.isApprox(sim.read().oTb, 1e-9)


def test_points_are_in_the_base_and_what_is_out_of_reach_is_at_its_end():
    wall = Geom(Box((0.05, 1.0, 1.0)), SE3(np.eye(3), np.array([4.0, 0.0, 1.0])), "wall")
    far = Geom(Box((0.05, 1.0, 1.0)), SE3(np.eye(3), np.array([0.0, 16.0, 1.0])), "too far")
    scan = Solid(world=World([FLOOR, wall, far], [])).robot.laser.latest(inf)
    seen = np.isfinite(scan.ranges)
    assert scan.ranges.shape == (241,)
    assert scan.points.shape == (241, 3)
    assert np.isposinf(scan.ranges[~seen]).all()
    far = np.linalg.norm(scan.points[~seen, :2] - [0.25, 0.0], axis=1)
    np.testing.assert_allclose(far, 15.0)
    assert 25 < seen.sum() < 35  # 2 m wide at 3.7 m
    x, _, z = scan.points[seen].T
    assert 0.005 < np.std(x) < 0.02
    np.testing.assert_allclose(x, 3.95, atol=0.05)
    np.testing.assert_allclose(z, HIGH)


def test_scans_come_at_their_rate_and_depend_on_seed_and_time_only():
    def scans(seed: int, every: int) -> list:
        backend = open_backend("omni", "kinematic", WorldOptions(scene="crossing", seed=seed))
        seen = []
        for tick in range(61):
            backend.robot.read()
            if tick % every == 0:
                scan = backend.robot.laser.latest(1.0)
                if not seen or scan is not seen[-1]:
                    seen.append(scan)
            backend.clock.sleep_until(backend.clock.now() + 0.01)
        return seen

    often, seldom, other = scans(2, 1), scans(2, 20), scans(3, 20)
    assert [round(scan.stamp, 6) for scan in often] == [0.0, 0.2, 0.4, 0.6]
    for one, same, different in zip(often, seldom, other, strict=True):
        np.testing.assert_array_equal(one.ranges, same.ranges)
        assert not np.array_equal(one.ranges, different.ranges)


def test_an_old_scan_is_none_and_so_is_that_of_a_robot_without_a_laser():
    sim = Solid(world=open_floor())
    assert sim.robot.laser.latest(0.1) is sim.robot.laser.latest(0.1)
    sim.clock.sleep_until(0.15)
    assert sim.robot.laser.latest(0.1) is None
    assert sim.robot.laser.latest(0.2) is not None


def test_a_held_object_belongs_to_the_robot():
    world = World([FLOOR], [block(x=1.0)])
    world.objects[0].pose = SE3(np.eye(3), np.array([1.0, 0.0, HIGH]))
    sim = Solid(world=world)
    assert np.isfinite(sim.robot.laser.latest(inf).ranges).any()
    world.held = world.objects[0]
    world.eTs = sim.robot._arm.body.wTe.actInv(world.held.pose)
    sim.clock.sleep_until(0.3)
    assert not np.isfinite(sim.robot.laser.latest(inf).ranges).any()
