"""Collisions of the kinematic robot: every part stops at a contact and can leave again."""

import numpy as np
import pytest
from pinocchio import SE3, exp3
from solid_world import Solid, box, cube, turning

from controller import Command
from hw import FaultKind
from hw.sim import SimObject, Walker, load_scene
from hw.sim.contact import separation, travel
from hw.sim.sim_robot_shapes import frames, members
from robots import Box, Geom

FORWARD = Command(base_twist=np.array([0.5, 0.0, 0.0]), qd=np.zeros(7))
LEG = box("table/leg", (0.6, 0.1, 0.25), (0.025, 0.025, 0.25))
FACE = 0.575  # side of the leg that faces the robot [m]
FRONT = 0.35  # from the middle of the base to its front [m]


def test_a_base_at_a_table_leg_stands_says_so_and_leaves_after_a_recovery():
    sim = Solid(LEG)
    assert sim.drive((0.5, 0.0, 0.0), s=1.5) == [("bumper", "the base hit table/leg")]
    state = sim.robot.read()
    (fault,) = state.faults
    assert (fault.kind, fault.clearable) == (FaultKind.BUMPER, True)
    assert abs(fault.bearing) < 0.1
    assert -0.005 < sim.x + FRONT - FACE <= 0.002
    assert not state.base_twist.any()
    assert not sim.robot.send(FORWARD).base_twist.any()
    before, q = sim.x, sim.robot.read().q[0]
    sim.drive((0.5, 0.0, 0.0), turning(1, 0.2), s=0.5)
    assert sim.x == before
    assert sim.robot.read().q[0] > q + 0.08, "the bumper leaves the arm alone"
    assert sim.touches == ["the base hit table/leg"]
    touch = sim.world.touches[0]
    assert (touch.part, touch.thing) == ("base", "table/leg")
    assert 0.45 < touch.stamp < 0.75
    for _ in range(3):
        sim.robot.recover()
        assert sim.faults == []
        assert sim.drive((0.5, 0.0, 0.0), s=0.3) == [("bumper", "the base hit table/leg")]
    at_the_leg = sim.x
    assert at_the_leg + FRONT - FACE <= 0.004
    touches = len(sim.touches)
    sim.robot.recover()
    assert sim.drive((-0.3, 0.0, 0.0), s=1.5) == []
    assert sim.x < at_the_leg - 0.2
    sim.drive((0.5, 0.0, 0.0), s=2.0)
    assert len(sim.touches) == touches + 1


def test_a_link_that_is_pushed_into_a_shelf_trips_the_reflex_by_its_name():
    x, y, z = Solid().link(4)
    sim = Solid(box("shelf/plate", (x - 0.14, y, z), (0.05, 0.3, 0.01)))  # 3 cm behind the elbow
    faults = sim.drive(qd=turning(2, -0.5), s=0.5)
    assert faults == [("reflex", "link4 hit shelf/plate")]
    q = sim.robot.read().q
    assert sim.drive(qd=turning(2, -0.5), s=0.3) == faults
    np.testing.assert_array_equal(sim.robot.read().q, q)
    assert sim.drive((0.2, 0.0, 0.0), s=0.5) == faults
    assert sim.x > 0.07, "the reflex leaves the base alone"
    sim.robot.recover()
    assert sim.drive(qd=turning(2, 0.5), s=0.5) == []
    assert sim.touches == ["link4 hit shelf/plate"]


def test_a_base_whose_arm_is_at_a_wall_goes_no_further_and_can_drive_back():
    x, y, z = Solid().link(7)
    sim = Solid(box("wall", (x + 0.35, y, z), (0.1, 0.5, 0.03)))
    assert [kind for kind, _ in sim.drive((0.5, 0.0, 0.0), s=0.8)] == ["reflex"]
    before = sim.x
    sim.drive((0.5, 0.0, 0.0), s=1.0)
    assert sim.x - before < 0.005
    sim.robot.recover()
    assert sim.faults == []
    assert [kind for kind, _ in sim.drive((0.2, 0.0, 0.0), s=0.3)] == ["reflex"]
    sim.drive(s=2.0)  # sooner the arm is not recovered again
    sim.robot.recover()
    assert sim.drive((-0.5, 0.0, 0.0), s=1.5) == []


def test_what_is_held_hits_a_shelf_and_both_are_named():
    sim = Solid()
    wTe = sim.body.wTe
    x, y, z = wTe.translation
    sim = Solid(box("shelf", (x + 0.3, y, z), (0.1, 0.3, 0.01)), objects=[cube("can", (x, y, z))])
    sim.robot.grip(0.0, 20.0)
    sim.drive(s=1.0)
    assert sim.world.held is not None
    faults = sim.drive((0.2, 0.0, 0.0), s=1.5)
    assert faults == [("reflex", "can in the hand hit shelf")]
    assert sim.world.touches[0].part == "held object"
    assert sim.world.touches[0].thing == "shelf"


def test_an_object_that_is_swept_off_its_post_falls_to_the_floor():
    x, y, z = Solid().body.wTe.translation
    post = box("post", (x + 0.2, y, (z - 0.04) / 2.0), (0.03, 0.03, (z - 0.04) / 2.0))
    can = SimObject(
        name="can",
        parts=(Geom(Box((0.02, 0.02, 0.06)), SE3.Identity(), "can"),),
        mass=0.1,
        pose=SE3(np.eye(3), np.array([x + 0.2, y, z + 0.02])),
    )
    sim = Solid(post, objects=[can])
    assert sim.world.resting_on(can) == "post"
    sim.drive((0.6, 0.0, 0.0), s=0.7)
    assert sim.touches == ["the hand hit can"]
    assert sim.world.resting_on(can) == "floor"


def test_a_walker_that_runs_into_a_standing_base_presses_its_bumper_until_it_has_passed():
    walker = Walker("Ada", 0.2, 1.7, [(0.5, -1.5), (0.5, 1.5)], 1.0)
    sim = Solid(walkers=[walker])
    assert any(shape.name == "Ada" for shape in sim.body.shapes())
    sim.drive(s=1.6)
    assert ("bumper", "the base hit Ada") in sim.faults
    sim.drive(s=2.0)
    sim.robot.recover()
    assert sim.faults == []
    assert sim.drive((0.2, 0.0, 0.0), s=0.3) == []


def test_the_bounds_of_gaps_miss_no_contact():
    """The same contacts as by measuring every pair, along a random way through furniture."""
    world = load_scene("household", 0)
    sim = Solid(world=world)
    rng = np.random.default_rng(5)
    shapes, deepest, contacts = members(sim.model.description), 0.0, 0
    q, width = sim.body.q.copy(), 0.08
    for tick in range(250):
        if tick % 60 == 0:
            wTb = SE3(np.eye(3), np.array([2.4, 0.0, 0.0]))
        turn = exp3(np.array([0.0, 0.0, rng.uniform(-0.05, 0.05)]))
        wTb = SE3(wTb.rotation @ turn, wTb.translation + rng.uniform(-0.02, 0.02, 3) * (1, 1, 0))
        q = np.clip(q + rng.uniform(-0.05, 0.05, 7), sim.model.limits.q_min, sim.model.limits.q_max)
        found = sim.body._collisions.find(wTb, q, width)
        told = {(one.part, one.thing): one.depth for one in found if one.excess > 0.0}
        at = frames(sim.model, wTb, q)
        expected: dict[tuple[str, str], float] = {}
        for member in shapes:
            shape = member.geom.moved(at[member.frame])
            for other in world.shapes():
                if member.part == "base" and other.name == "floor":
                    continue
                depth = -separation(shape, other)[0]
                if depth > member.tolerance:
                    key = member.part, other.name
                    expected[key] = max(depth, expected.get(key, 0.0))
        assert told.keys() == expected.keys()
        for key, depth in told.items():
            assert depth == pytest.approx(expected[key], abs=1e-6)
            deepest = max(deepest, depth)
        contacts += len(told)
    assert contacts > 60
    assert deepest > 0.02


HALF = (0.02, 0.03, 0.025)


def fall(x: float, y: float, height: float, turn: np.ndarray) -> float | None:
    """Of a block from a height over a table, turned by a rotation vector (3,)."""
    here = SE3(exp3(turn), np.array([x, y, 0.5 + HALF[2] + height]))
    table = box("table", (0.8, 0.0, 0.25), (0.4, 0.4, 0.25))
    return travel(Geom(Box(HALF), here), np.array([0.0, 0.0, -1.0]), [table], 1.0)


def test_a_block_that_falls_on_a_table_stops_on_it_however_its_numbers_are_rounded():
    rng = np.random.default_rng(0)
    for _ in range(300):
        x, y, height = rng.uniform((0.5, -0.3, 0.01), (1.1, 0.3, 0.4))
        turn = rng.choice([0.0, 1e-12, 1e-5]) * rng.normal(size=3)
        assert fall(x, y, height, turn) == pytest.approx(height, abs=1e-4)
    assert fall(0.37, 0.0, 0.2, np.zeros(3)) is None
