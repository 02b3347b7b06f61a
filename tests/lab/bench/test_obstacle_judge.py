"""Worlds with obstacles, seeded and solvable, and their judge on constructed contacts."""

from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from pinocchio import SE3

from controller import robot_model
from hw.sim.contact import separation
from lab.bench.contacts import CAPSULES, ContactChecker
from lab.bench.obstacles.contact_judge import Judge
from lab.bench.obstacles.convex_distances import Placed, distances
from lab.bench.obstacles.obstacle_worlds import FAMILIES, WorldMaker
from lab.bench.obstacles.reachability import FOLDED, Paths
from lab.bench.obstacles.walkers import Walker
from robots import Box, Capsule, Cylinder, Geom, load_robot

PERIOD = 0.01


FRANKIE = load_robot("frankie")


FRONT = FRANKIE.base.size[0] / 2.0


def upright(x, y, z, heading=0.0):
    return SE3(pin.utils.rotate("z", heading), np.array([x, y, z]))


def distance(part, around, within=10.0):
    return distances(Placed.fixed(part, 1), Placed.fixed(around, 1), within)[0]


LINK = Capsule(0.05, 0.1)


BODY = Box((0.3, 0.2, 0.1))


BLOCK, COLUMN = Box((1.0, 1.0, 1.0)), Cylinder(0.1, 1.0)


TURNED = np.pi / 4.0


@pytest.mark.parametrize(
    ("part", "at", "around", "expected"),
    [
        (LINK, upright(0, 0, 0), Box((1.0, 1.0, 0.01)), -0.06),  # upright through a board
        (BODY, upright(1.5, 0, 0, TURNED), BLOCK, 0.5 - 0.25 * np.sqrt(2.0)),  # edge to face
        (BODY, upright(0, 0, 0), Cylinder(0.05, 1.0), -0.1),  # a post in the middle, 0.1 m high
        (BODY, upright(-0.395, 0, 0), COLUMN, -0.005),  # before a face
    ],
)
def test_distances_are_those_of_geometry(part, at, around, expected):
    found = distance(Geom(part, at), Geom(around, SE3.Identity()))
    assert found == pytest.approx(expected, abs=1e-4)


def test_distances_agree_with_another_implementation():
    rng, compared = np.random.default_rng(0), 0
    parts = (Capsule(0.05, 0.1), Box((0.35, 0.25, 0.19)), Box((0.03, 0.1, 0.04)))
    obstacles = (Box((0.3, 0.2, 0.02)), Cylinder(0.2, 0.5), Box((0.02, 0.02, 0.4)))
    for number in range(180):
        turned = pin.exp3(rng.uniform(-np.pi, np.pi, 3))
        part = Geom(parts[number % 3], SE3(turned, rng.uniform(-0.6, 0.6, 3)))
        place = upright(*rng.uniform(-0.5, 0.5, 3), rng.uniform(-np.pi, np.pi))
        around = Geom(obstacles[number // 3 % 3], place)
        other = separation(part, around)[0]
        if other > 1e-3:
            assert distance(part, around) == pytest.approx(other, abs=1e-4)
            compared += 1
        elif other < -1e-3:
            assert distance(part, around) < 0.0
    assert compared > 80


def drive(distance, samples=200):
    """Straight ahead, arm ready."""
    base = np.column_stack([np.linspace(0.0, distance, samples), np.zeros((samples, 2))])
    return base, np.tile(FRANKIE.arm.ready, (samples, 1))


def crate(x, height=0.3):
    """A box whose near face is x ahead of the start."""
    return Geom(Box((0.2, 0.2, height / 2.0)), upright(x + 0.2, 0.0, height / 2.0), "crate")


@pytest.mark.parametrize("room", [0.001, -0.001])
def test_clearance_and_depth_are_right_to_a_tenth_of_a_millimetre(room):
    base, q = drive(0.4)
    verdict = Judge(FRANKIE)(base, q, PERIOD, [crate(FRONT + 0.4 + room)])
    assert verdict.clearance == pytest.approx(room, abs=1e-4)
    assert bool(verdict.touches) == (room < 0.0)
    if verdict.touches:
        assert verdict.touches[0].depth == pytest.approx(-room, abs=1e-4)


def test_a_hand_in_the_floor_touches_it_and_wheels_do_not():
    reaching_down = np.array([0.0, 1.7, 0.0, -1.2, 0.0, 2.4, 0.8])
    judge = Judge(load_robot("omni"))
    for q, expected in ((FRANKIE.arm.ready, set()), (reaching_down, {"floor"})):
        verdict = judge(np.zeros((1, 3)), q[None], PERIOD, [])
        assert {touch.obstacle for touch in verdict.touches} == expected


def walker(**changes):
    """A walker from ahead, straight towards the robot."""
    fields = {
        "name": "walker",
        "shape": Cylinder(0.25, 0.85),
        "start": np.array([4.0, 0.0]),
        "direction": np.array([-1.0, 0.0]),
        "speed": 0.8,
    }
    return Walker(**(fields | changes))


def judged(base, **changes):
    q = np.tile(FRANKIE.arm.ready, (len(base), 1))
    return Judge(FRANKIE)(base, q, PERIOD, [], [walker(**changes)])


ALONG, ACROSS = 0.0, np.pi / 2.0


BESIDE = FRANKIE.base.size[1] / 2.0 + 0.25
"""Where a walker touches the side of a base that stands across [m]."""


LATE = {"start": np.array([BESIDE - 0.1, 0.0]), "direction": np.array([1.0, 0.0]), "length": 0.2}


def standing(heading, samples=500):
    return np.tile([0.0, 0.0, heading], (samples, 1))


def test_contacts_that_a_standing_robot_could_not_avoid():
    """Along the walker's line it cannot leave sideways; a turn of the walker comes too late."""
    verdict = judged(standing(ALONG))
    assert verdict.samples > 50
    assert verdict.avoidable_samples == 0
    verdict = judged(standing(ACROSS, 200), **LATE, phase=0.15)
    assert verdict.samples > 0
    assert verdict.avoidable_samples == 0


def test_contacts_that_a_robot_could_have_avoided():
    """It stands across the walker's line, drives into the walker, or drives into its way."""
    times = np.arange(600) * PERIOD
    zero = times * 0.0
    into_the_walker = np.column_stack([0.5 * times, zero, zero])
    into_the_way = np.column_stack([zero, np.minimum(-3.0 + 0.7 * times, 0.0), zero + ACROSS])
    for base in (standing(ACROSS), into_the_walker[:500], into_the_way):
        verdict = judged(base)
        assert verdict.avoidable_samples == verdict.samples > 50


@pytest.mark.parametrize("brakes", [True, False])
def test_a_walker_that_turns_back_before_a_braking_robot_excuses_the_contact(brakes):
    """It walks away ahead of the robot and turns back when the robot is near."""
    turns, speed = 1.0, 0.8
    acceleration = float(FRANKIE.limits.base_acceleration[0])
    times = np.arange(300) * PERIOD
    late = np.maximum(times - turns - FRANKIE.base.lag, 0.0)
    left = np.maximum(speed - acceleration * late * brakes, 0.0)
    base = np.column_stack([np.cumsum(left) * PERIOD, np.zeros((300, 2))])
    start = np.array([speed * turns + 0.95 + FRONT, 0.0])
    verdict = judged(base, start=start, direction=np.array([-1.0, 0.0]), length=5.0, phase=9.2)
    assert verdict.samples > 0
    assert bool(verdict.avoidable_samples) == (not brakes)


@cache
def maker(robot):
    return WorldMaker(robot_model(robot))


def test_the_same_seed_gives_the_same_world_and_another_gives_another():
    once, again, other = (maker("frankie")("walkers", 1, seed) for seed in (3, 3, 4))
    assert len({fixture.name for fixture in once.fixtures}) == len(once.fixtures)
    assert once.goal == again.goal != other.goal
    assert [one.pose for one in once.fixtures] == [one.pose for one in again.fixtures]
    times = np.linspace(0.0, 10.0, 20)
    walked, walked_again = (
        [walker.positions(times) for walker in world.walkers] for world in (once, again)
    )
    np.testing.assert_array_equal(walked, walked_again)


def shapes(model, mTb, q):
    """Arm, base and hand, computed independently of the judge."""
    robot, links = model.description, model.link_poses(mTb, q)
    for capsule in CAPSULES[:-2]:
        ends = np.array([capsule.start, capsule.end])
        for share in np.linspace(0.0, 1.0, 9):
            place = links[capsule.link].act(ends[0] + share * (ends[1] - ends[0]))
            half = Box((1e-4, 1e-4, 1e-4))
            yield Geom(half, SE3(np.eye(3), place)), capsule.radius
    mTe = model.end_effector(mTb, q)
    yield robot.gripper.palm.moved(mTe), 0.0
    yield robot.camera.body.moved(mTe * robot.camera.eTc), 0.0
    length, width, height = robot.base.size
    middle = SE3(np.eye(3), np.array([0.0, 0.0, height / 2.0]))
    yield Geom(Box((length / 2.0, width / 2.0, height / 2.0)), mTb * middle), 0.0


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_start_and_stance_are_free_and_the_tool_is_at_the_goal(robot):
    model = robot_model(robot)
    checker = ContactChecker(model)
    for family in FAMILIES:
        world = maker(robot)(family, 0, 0)
        x, y, heading = world.stance.base
        mTb = SE3(pin.utils.rotate("z", heading), np.array([x, y, 0.0]))
        reached = model.end_effector(mTb, world.stance.q)
        assert np.abs(reached.homogeneous - world.goal.homogeneous).max() < 1e-9
        assert not checker(world.stance.q)
        for place, q in ((mTb, world.stance.q), (SE3.Identity(), model.description.arm.ready)):
            for part, radius in shapes(model, place, q):
                assert all(
                    separation(part, fixture)[0] - radius > 0.028 for fixture in world.fixtures
                )


def test_goals_are_where_their_family_says():
    world = maker("frankie")("shelf", 0, 0)
    back = next(fixture for fixture in world.fixtures if fixture.name == "shelf back")
    inside = back.pose.actInv(world.goal).translation
    assert -0.45 < inside[0] < 0.0
    assert abs(inside[1]) < 0.7
    world = maker("frankie")("table", 0, 0)
    top = next(fixture for fixture in world.fixtures if fixture.name == "table top")
    assert world.goal.rotation[2, 2] < -0.9
    above = top.pose.actInv(world.goal).translation
    assert (np.abs(above[:2]) < np.array(top.shape.half)[:2]).all()
    assert above[2] > 0.0
    assert maker("frankie")("walkers", 0, 0).walkers


def paths(fixtures):
    model = robot_model("frankie")
    return Paths(model, Judge(model.description), ContactChecker(model), fixtures)


STANCE = (np.array([2.5, 0.0, 0.0]), FOLDED)


def wall(y_from, y_to):
    half = (y_to - y_from) / 2.0
    place = np.array([1.25, y_from + half, 1.0])
    return Geom(Box((0.05, half, 1.0)), SE3(np.eye(3), place), "wall")


def test_a_path_needs_a_wide_gap_and_a_free_start():
    assert paths([]).reaches(*STANCE)
    assert paths([wall(-6.0, 2.0)]).reaches(*STANCE)
    assert not paths([wall(-6.0, 6.0)]).reaches(*STANCE)
    assert paths([wall(-6.0, 1.0), wall(2.1, 6.0)]).reaches(*STANCE)
    assert not paths([wall(-6.0, 1.0), wall(1.8, 6.0)]).reaches(*STANCE)
    assert paths([]).start_is_free
    post = Geom(Box((0.05, 0.05, 1.0)), SE3(np.eye(3), np.array([0.0, 0.36, 1.0])), "post")
    assert not paths([post]).start_is_free
