"""The base sets out for the next goal while the hand is busy with this one."""

import numpy as np
import pinocchio as pin
import pytest
from harness import (
    ON_TABLE,
    TABLE_TOP,
    Harness,
    block,
    looking_down,
    over_the_table,
    table_world,
    with_the_hand_at,
)
from pinocchio import SE3
from pinocchio.utils import rotate
from py_trees.common import Status

from behaviours import Leaf, OpenGripper, ToolPose
from behaviours.grasp import Grasp
from behaviours.navigate import Navigate
from controller import PoseGoal
from hw.sim import Motion

BEHIND = looking_down(-3.0, 1.5, 0.8)


class Keep(Leaf):
    """Keeps the hand where it is."""

    key = "keep"

    def __init__(self, context, oTe: SE3, onward: SE3 | None) -> None:
        super().__init__("keep", context)
        self._goal = PoseGoal(target=oTe, straight=True, next_goal=onward)
        self.errors: list[tuple[float, float]] = []

    def update(self) -> Status:
        report = self.pursue(self._goal)
        if report is not None:
            self.errors.append((report.position_error, report.orientation_error))
        return self.running("keeping")


def keep(
    robot: str, seconds: float, onward: SE3 | None = BEHIND, turned: float = 0.0
) -> tuple[Harness, Keep]:
    harness = Harness(robot=robot)
    harness.reach_over(looking_down(0.65, 0.1, 0.6) * SE3(rotate("z", turned), np.zeros(3)))
    here = harness.robot.read()
    leaf = Keep(harness.context, harness.controller.model.end_effector(here.oTb, here.q), onward)
    harness.run_for(leaf, seconds)
    return harness, leaf


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_the_hand_stays_within_millimetres_while_the_base_is_on_its_way(robot):
    harness, leaf = keep(robot, 5.0)
    assert np.abs(pin.rpy.matrixToRpy(harness.robot.read().oTb.rotation)[2]) > 0.3
    positions, angles = zip(*leaf.errors, strict=True)
    assert max(positions) < 0.005
    assert max(angles) < np.deg2rad(0.5)


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_the_base_stops_before_the_arm_is_at_its_end(robot):
    harness, leaf = keep(robot, 12.0)
    then = harness.robot.read().oTb
    harness.run_for(leaf, 2.0)
    assert max(position for position, _ in leaf.errors) < 0.01
    moved = pin.log6(then.actInv(harness.robot.read().oTb)).vector
    assert np.abs(moved).max() < 0.05 * 2.0


def test_after_an_attempt_in_vain_the_base_stands_while_the_hand_grasps():
    there = ToolPose(name="there", mTe=looking_down(-3.0, 1.5, 0.8))
    up = ToolPose(name="up", mTe=looking_down(0.6, 0.0, 0.85))
    ends = []
    for second in ("the same", "standing", "another"):
        harness = over_the_table(block())
        context = harness.context
        first, standing, another = (
            Grasp("grasp", context, within=ON_TABLE, next_goal=goal)
            for goal in (there, None, there)
        )
        again = {"the same": first, "standing": standing, "another": another}[second]
        for leaf in (first, Navigate("up", context, to=up), OpenGripper("open", context), again):
            assert harness.run(leaf) is Status.SUCCESS
        ends.append(harness.robot.read().oTb)
    the_same, standing, another = ends
    assert the_same == standing
    assert np.linalg.norm(pin.log3(another.rotation.T @ standing.rotation)) > 0.2  # it turns to it


def test_what_moves_is_gripped_where_it_has_come():
    velocity = np.array([0.0, 0.1, 0.0])
    thing = block(x=0.7, y=0.0)
    start = thing.pose.translation - 2.0 * velocity
    thing.pose = SE3(thing.pose.rotation, start)
    thing.motion = Motion(start=start, along=4.0 * velocity, period=8.0, steady=True)
    harness = with_the_hand_at(table_world(thing), 0.6, -0.1, TABLE_TOP + 0.5)
    leaf = Grasp("grasp", harness.context, within=ON_TABLE)
    harness.run_into(leaf, "close")
    away = thing.pose.translation - harness.context.oTe.translation
    assert np.hypot(*away[:2]) < 0.03  # it moves 0.1 m between lock and grip
    assert harness.run(leaf) is Status.SUCCESS
    assert harness.world.held is thing
