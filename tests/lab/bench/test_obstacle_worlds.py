"""Worlds with obstacles: seeded, with goals that are free and reachable."""

from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from pinocchio import SE3

from controller import robot_model
from hw.sim.contact import separation
from lab.bench.contacts import CAPSULES, ContactChecker
from lab.bench.obstacles.judge import Judge
from lab.bench.obstacles.reachability import FOLDED, Paths
from lab.bench.obstacles.worlds import FAMILIES, WorldMaker
from robots import Box, Geom


@cache
def maker(robot):
    return WorldMaker(robot_model(robot))


def poses(world):
    return np.array([fixture.pose.homogeneous for fixture in world.fixtures])


def test_the_same_seed_gives_the_same_world_and_another_gives_another():
    once, again, other = (maker("frankie")("walkers", 1, seed) for seed in (3, 3, 4))
    assert len({fixture.name for fixture in once.fixtures}) == len(once.fixtures)
    assert (once.goal.homogeneous == again.goal.homogeneous).all()
    assert (poses(once) == poses(again)).all()
    assert np.abs(once.goal.homogeneous - other.goal.homogeneous).max() > 1e-3
    for one, two in zip(once.walkers, again.walkers, strict=True):
        times = np.linspace(0.0, 10.0, 20)
        assert (one.positions(times) == two.positions(times)).all()


def shapes(model, wTb, q):
    """Arm, base and hand, computed independently of the judge."""
    robot, links = model.description, model.link_poses(wTb, q)
    for capsule in CAPSULES[:-2]:
        ends = np.array([capsule.start, capsule.end])
        for share in np.linspace(0.0, 1.0, 9):
            place = links[capsule.link].act(ends[0] + share * (ends[1] - ends[0]))
            half = Box((1e-4, 1e-4, 1e-4))
            yield Geom(half, SE3(np.eye(3), place)), capsule.radius
    wTe = model.wTe(wTb, q)
    yield robot.gripper.palm.moved(wTe), 0.0
    yield robot.camera.body.moved(wTe * robot.camera.eTc), 0.0
    length, width, height = robot.base.size
    middle = SE3(np.eye(3), np.array([0.0, 0.0, height / 2.0]))
    yield Geom(Box((length / 2.0, width / 2.0, height / 2.0)), wTb * middle), 0.0


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_start_and_stance_are_free_and_the_tool_is_at_the_goal(robot):
    model = robot_model(robot)
    checker = ContactChecker(model)
    for family in FAMILIES:
        world = maker(robot)(family, 0, 0)
        x, y, heading = world.stance.base
        wTb = SE3(pin.utils.rotate("z", heading), np.array([x, y, 0.0]))
        reached = model.wTe(wTb, world.stance.q)
        assert np.abs(reached.homogeneous - world.goal.homogeneous).max() < 1e-9
        assert not checker(world.stance.q)
        for place, q in ((wTb, world.stance.q), (SE3.Identity(), model.description.arm.ready)):
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
