"""Stances among furniture stand free by geometry of the test's own, found in bounded steps."""

import numpy as np
import pinocchio as pin
import pytest
from motion import READY, State, run_to, tool_pose
from pinocchio import SE3
from solid_world import box

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
from controller.floor.base_drive import Pose2D
from controller.floor.floor_map import FloorMap
from controller.servo import pose_error
from controller.stance.free_space import FreeSpace
from controller.stance.posture_bank import bank
from controller.stance.search import StanceSearch
from controller.stance.stance import Stance
from robots import Box, Capsule, Geom

ORIGIN = Pose2D(0.0, 0.0, 0.0)


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


def search(model: RobotModel, wTe: SE3, fixtures: tuple[Geom, ...]) -> StanceSearch:
    floor = FloorMap(fixtures, model.description)
    space = FreeSpace(model, floor) if fixtures else None
    body, postures = SelfCollision(model), bank(model.description)
    return StanceSearch(model, postures, body, wTe, ORIGIN, READY, space=space)


def distance_to_box(points: np.ndarray, fixture: Geom) -> float:
    """Least distance of points (N, 3) to a box, 0 inside of it."""
    assert isinstance(fixture.shape, Box)
    seen = (points - fixture.pose.translation) @ fixture.pose.rotation
    outside = np.maximum(np.abs(seen) - np.array(fixture.shape.half), 0.0)
    return float(np.linalg.norm(outside, axis=1).min())


def arm_clearance(model: RobotModel, wTb: SE3, q: np.ndarray, fixtures: tuple[Geom, ...]) -> float:
    """Of the capsules of foot and links, as rows of balls [m]."""
    least = np.inf
    for pose, capsules in zip(
        model.link_poses(wTb, q)[:8], model.description.arm.collision, strict=True
    ):
        for capsule in capsules:
            assert isinstance(capsule.shape, Capsule)
            placed = pose * capsule.pose
            along = np.linspace(-1.0, 1.0, 41)[:, None] * capsule.shape.half_length
            points = placed.translation + along * placed.rotation[:, 2]
            for fixture in fixtures:
                least = min(least, distance_to_box(points, fixture) - capsule.shape.radius)
    return least


def base_clearance(model: RobotModel, wTb: SE3, fixtures: tuple[Geom, ...]) -> float:
    """Of a grid of points in the box of the base [m]."""
    length, width, height = model.description.base.size
    axes = [np.linspace(-size / 2.0, size / 2.0, 25) for size in (length, width)]
    grid = np.stack(np.meshgrid(*axes, np.linspace(0.0, height, 9)), axis=-1).reshape(-1, 3)
    points = grid @ wTb.rotation.T + wTb.translation
    return min(distance_to_box(points, fixture) for fixture in fixtures)


def base_at(found: Stance, wTe: SE3) -> SE3:
    x, y, heading = found.base_for(wTe)
    return SE3(pin.utils.rotate("z", heading), np.array([x, y, 0.0]))


@pytest.mark.parametrize("robot", ["frankie", "omni"])
@pytest.mark.parametrize("goal", [over_the_table, in_the_shelf])
def test_stances_among_furniture_reach_the_goal_and_stand_free(robot, goal):
    model, rng = robot_model(robot), np.random.default_rng(1)
    found = 0
    for _ in range(10):
        wTe = goal(rng)
        if (one := search(model, wTe, ROOM).finish()) is None:
            continue
        found += 1
        wTb = base_at(one, wTe)
        error = pose_error(model.wTe(wTb, one.q), wTe)
        assert error.position < 0.005
        assert error.orientation < 0.02
        assert base_clearance(model, wTb, ROOM) > 0.04
        assert arm_clearance(model, wTb, one.q, ROOM) > 0.01
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
    goal = PoseGoal(wTe=UNREACHABLE[reason])
    run = run_to(goal, around=Surroundings(fixtures=YARD), seconds=1.5)
    assert not run.arrived
    assert all(reason in report.unreachable for report in run.reports[49:])
    assert run.state.wTb.isApprox(SE3.Identity(), 1e-9)
    np.testing.assert_allclose(run.state.q, READY, atol=1e-6)


def test_the_hand_may_be_told_that_it_may_touch():
    controller, around = HolisticController(robot_model("frankie")), Surroundings(fixtures=YARD)
    wTe = tool_pose(0.0, 1.45, 0.70)
    for may, said in ((False, True), (True, False)):
        goal = PoseGoal(wTe=wTe, straight=True, hand_may_touch=may)
        _, report = controller.step(State(), goal, Command.stop(7), around)
        assert bool(report.unreachable) == said


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_what_is_within_reach_has_a_stance_and_what_is_not_has_none(robot):
    model, rng, reached = robot_model(robot), np.random.default_rng(3), 0
    for _ in range(60):
        turn, tilt = rng.uniform(-np.pi, np.pi), rng.uniform(0.0, 1.6)
        wTe = tool_pose(2.0, 0.0, rng.uniform(0.9, 1.6), yaw=turn, tilt=tilt)
        found = search(model, wTe, ())
        found.finish()
        if out_of_reach(model.description, wTe):
            assert found.error > 0.005
        else:
            assert found.error < 0.02
            reached += 1
    assert 15 < reached < 45
