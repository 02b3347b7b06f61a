"""Stances stand free as Coal measures, beside their goal if need be, and soon on the way out."""

from math import atan2

import numpy as np
import pinocchio as pin
import pytest
from motion import READY, State, run_to, tool_pose
from pinocchio import SE3
from solid_world import box
from test_floor_map import distance

from config.planar import ORIGIN, Pose2D, wrap
from controller import (
    Command,
    HolisticController,
    PoseGoal,
    RobotModel,
    SelfCollision,
    Surroundings,
    out_of_reach,
    robot_model,
)
from controller.floor.floor_map import FloorMap
from controller.servo import pose_error
from controller.stance.free_space import FreeSpace
from controller.stance.posture_bank import bank
from controller.stance.search import StanceSearch
from controller.stance.stance import Stance
from robots import Box, Geom, load_robot, with_base_speeds

TABLE = (
    box("table/top", (0.0, 1.6, 0.70), (0.6, 0.4, 0.02)),
    *(box("table/leg", (x, y, 0.34), (0.03, 0.03, 0.34)) for x in (-0.5, 0.5) for y in (1.3, 1.9)),
)


SHELF = (
    *(box("shelf/board", (2.0, 0.0, z), (0.2, 0.5, 0.01)) for z in (0.1, 0.5, 0.9, 1.3)),
    *(box("shelf/side", (2.0, y, 0.65), (0.2, 0.01, 0.65)) for y in (-0.5, 0.5)),
    box("shelf/back", (2.2, 0.0, 0.65), (0.01, 0.5, 0.65)),
)


ROOM = TABLE + SHELF


def over_the_table(rng: np.random.Generator) -> SE3:
    x, y, z = rng.uniform([-0.4, 1.35, 0.88], [0.4, 1.8, 0.98])
    return tool_pose(x, y, z, yaw=rng.uniform(-np.pi, np.pi))


def in_the_shelf(rng: np.random.Generator) -> SE3:
    """Between two boards, the hand pointing inwards."""
    ahead = pin.rpy.rpyToMatrix(0.0, np.pi / 2.0 + rng.uniform(0.0, 0.3), rng.uniform(-0.3, 0.3))
    rotation = ahead @ pin.utils.rotate("z", np.pi)
    return SE3(rotation, rng.uniform([1.85, -0.25, 0.68], [2.0, 0.25, 0.72]))


def search(model: RobotModel, mTe: SE3, fixtures: tuple[Geom, ...]) -> StanceSearch:
    floor = FloorMap(fixtures, model.description)
    space = FreeSpace(model, floor) if fixtures else None
    body, postures = SelfCollision(model), bank(model.description)
    return StanceSearch(model, postures, body, mTe, ORIGIN, READY, space=space)


def arm_clearance(model: RobotModel, mTb: SE3, q: np.ndarray, fixtures: tuple[Geom, ...]) -> float:
    """Of the capsules of foot and links [m]."""
    links = zip(model.link_poses(mTb, q)[:8], model.description.arm.collision, strict=True)
    capsules = [one.moved(pose) for pose, some in links for one in some]
    return min(distance(one, fixture) for one in capsules for fixture in fixtures)


def base_clearance(model: RobotModel, mTb: SE3, fixtures: tuple[Geom, ...]) -> float:
    half = np.array(model.description.base.size) / 2.0
    body = Geom(Box(tuple(half)), mTb * SE3(np.eye(3), half * [0.0, 0.0, 1.0]))
    return min(distance(body, fixture) for fixture in fixtures)


def base_at(found: Stance, mTe: SE3) -> SE3:
    x, y, heading = found.base_for(mTe)
    return SE3(pin.utils.rotate("z", heading), np.array([x, y, 0.0]))


@pytest.mark.parametrize("robot", ["frankie", "omni"])
@pytest.mark.parametrize("goal", [over_the_table, in_the_shelf])
def test_stances_among_furniture_reach_the_goal_and_stand_free(robot, goal):
    model, rng = robot_model(robot), np.random.default_rng(1)
    found = 0
    for _ in range(10):
        mTe = goal(rng)
        if (one := search(model, mTe, ROOM).finish()) is None:
            continue
        found += 1
        mTb = base_at(one, mTe)
        error = pose_error(model.end_effector(mTb, one.q), mTe)
        assert error.position < 0.005
        assert error.orientation < 0.02
        assert base_clearance(model, mTb, ROOM) > 0.04
        assert arm_clearance(model, mTb, one.q, ROOM) > 0.01
        assert SelfCollision(model).clearance(one.q) > 0.0
    assert found >= 8


UNREACHABLE = {
    "2.60 m up": tool_pose(2.0, -1.0, 2.6),
    "1.35 m up: tilted like this": tool_pose(2.0, -1.0, 1.35),
    "0.50 m below the floor": tool_pose(2.0, -1.0, -0.5),
    "inside table/top": tool_pose(0.0, 1.6, 0.70),
    "the hand would be inside table/top": tool_pose(0.0, 1.6, 0.62),
    "no stance stands free of": tool_pose(1.7, 4.0, 0.9),
}
"""What is said, and of which goal. The last one is on the far side of a fence."""


YARD = (box("fence", (1.7, 4.0, 0.2), (1.5, 1.5, 0.2)), *ROOM)


@pytest.mark.parametrize("reason", UNREACHABLE)
def test_a_goal_out_of_reach_is_said_at_once_and_the_robot_stays_where_it_is(reason):
    goal = PoseGoal(target=UNREACHABLE[reason])
    run = run_to(goal, around=Surroundings(fixtures=YARD), seconds=1.5)
    assert not run.arrived
    assert all(reason in report.unreachable for report in run.reports[49:])
    assert run.state.mTb.isApprox(SE3.Identity(), 1e-9)
    np.testing.assert_allclose(run.state.q, READY, atol=1e-6)


def test_the_hand_may_be_told_that_it_may_touch():
    controller, around = HolisticController(robot_model("frankie")), Surroundings(fixtures=YARD)
    mTe = tool_pose(0.0, 1.45, 0.70)
    for may, said in ((False, True), (True, False)):
        goal = PoseGoal(target=mTe, straight=True, hand_may_touch=may)
        _, report = controller.step(State(), goal, Command.stop(7), around)
        assert bool(report.unreachable) == said


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_what_is_within_reach_has_a_stance_and_what_is_not_has_none(robot):
    model, rng, reached = robot_model(robot), np.random.default_rng(3), 0
    for _ in range(60):
        turn, tilt = rng.uniform(-np.pi, np.pi), rng.uniform(0.0, 1.6)
        mTe = tool_pose(2.0, 0.0, rng.uniform(0.9, 1.6), yaw=turn, tilt=tilt)
        found = search(model, mTe, ())
        found.finish()
        if out_of_reach(model.description, mTe):
            assert found.error > 0.005
        else:
            assert found.error < 0.02
            reached += 1
    assert 15 < reached < 45


BESIDE_THE_WAY = tool_pose(3.0, 0.72, 0.85, yaw=np.pi / 2.0)


AHEAD = tool_pose(6.0, 0.0, 0.85)


BACK = tool_pose(0.0, -3.0, 0.85)


LONG_TABLE = box("table", (3.0, 0.9, 0.35), (1.0, 0.3, 0.35))


def base_for(
    model: RobotModel, mTe: SE3, onward: SE3 | None, fixtures=(), mTb: Pose2D = ORIGIN
) -> Pose2D:
    space = FreeSpace(model, FloorMap(fixtures, model.description)) if fixtures else None
    body, postures = SelfCollision(model), bank(model.description)
    here = StanceSearch(model, postures, body, mTe, mTb, READY, space=space, next_goal=onward)
    found = here.finish()
    return found.base_for(mTe)


def turns(stood: Pose2D, to: SE3) -> float:
    """By how much a base turns on its way from where it was to a stance and on from there [rad]."""
    x, y, _ = to.translation
    into = atan2(stood.y, stood.x)
    out = atan2(y - stood.y, x - stood.x)
    return abs(into) + abs(wrap(stood.heading - into)) + abs(wrap(out - stood.heading))


def test_a_base_that_knows_where_it_goes_next_hardly_turns_on_its_way_past_a_table():
    model, fixtures = robot_model("frankie"), (LONG_TABLE,)
    knowing = base_for(model, BESIDE_THE_WAY, AHEAD, fixtures)
    other = base_for(model, BESIDE_THE_WAY, BACK, fixtures)
    assert turns(knowing, AHEAD) < 0.4
    assert turns(knowing, AHEAD) < 0.5 * turns(other, AHEAD)


def test_a_base_that_comes_round_a_corner_stands_as_it_arrives():
    # As the crow flies it would come along -x; round the end of the wall it comes along y.
    wall = box("wall", (1.25, 2.55, 0.8), (0.5, 2.0, 0.8))
    table = box("table", (0.0, 1.6, 0.25), (0.6, 0.3, 0.25))
    over_table = tool_pose(0.0, 1.4, 0.85, yaw=np.pi / 2.0)
    behind_wall = Pose2D(2.2, 0.2, -0.5)
    stood = base_for(robot_model("frankie"), over_table, None, (wall, table), behind_wall)
    assert stood.heading < 2.5


@pytest.mark.parametrize("side", [-3.0, 3.0])
def test_a_holonomic_base_stands_on_the_side_that_it_leaves_to(side):
    model, mTe = robot_model("omni"), tool_pose(2.0, 0.0, 0.6)
    stood = base_for(model, mTe, tool_pose(2.0, side, 0.6))
    assert np.sign(stood.y) == np.sign(side)


BEHIND = tool_pose(-2.5, 1.2, 0.85, yaw=np.pi / 2.0)
"""A place behind the robot and beside its way, the hand pointing down."""


@pytest.fixture(scope="module")
def both_ways() -> RobotModel:
    """Frankie with a base that backs as fast as it drives."""
    return RobotModel(with_base_speeds(load_robot("frankie"), 1.0, 1.0))


def test_a_base_that_backs_as_fast_does_not_turn_to_a_goal_but_to_one_that_it_follows(both_ways):
    where = SelfCollision(both_ways), BEHIND, Pose2D(0.0, 0.0, 0.0), READY
    beside, in_front = (
        StanceSearch(both_ways, bank(both_ways.description), *where, in_front=in_front).finish()
        for in_front in (False, True)
    )
    assert beside.reverse
    assert abs(beside.base_for(BEHIND).heading) < 0.5
    assert beside.bearing > 0.8
    assert abs(in_front.bearing) < 0.3


def headings_at(model: RobotModel, goals: list[PoseGoal]) -> list[float]:
    """Reach one goal after the other: the heading of the base at each of them [rad]."""
    controller, run, headings = HolisticController(model), None, []
    for goal in goals:
        before = {"state": run.state, "last": run.commands[-1]} if run else {}
        run = run_to(goal, controller=controller, seconds=15.0, **before)
        assert run.arrived
        headings.append(Pose2D.of(run.state.mTb).heading)
    return headings


def test_a_base_that_stands_beside_its_goal_does_not_turn_to_it_while_the_hand_goes_down(both_ways):
    down = SE3(BEHIND.rotation, BEHIND.translation - np.array([0.0, 0.0, 0.2]))
    goals = [PoseGoal(target=BEHIND), PoseGoal(target=down, straight=True)]
    above, below = headings_at(both_ways, goals)
    assert abs(above) < 0.5
    assert abs(below - above) < 0.15


def test_a_base_goes_on_to_the_stance_that_it_has_set_out_for(both_ways):
    """It is led there from the first period on: no search, in which it would come to rest."""
    controller = HolisticController(both_ways)
    here = both_ways.end_effector(SE3.Identity(), READY)
    up = SE3(here.rotation, here.translation + np.array([0.0, 0.0, 0.1]))
    goal = PoseGoal(target=up, straight=True, next_goal=BEHIND)
    run = run_to(goal, controller=controller, seconds=0.3)
    assert run.reports[-1].stance is None
    _, report = controller.step(run.state, PoseGoal(target=BEHIND), run.commands[-1])
    assert report.stance is not None
