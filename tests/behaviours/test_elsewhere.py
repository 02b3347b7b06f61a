"""Where the straight way does not get there: placing, grasping and driving from elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
from harness import TABLE_TOP, Harness, block, looking_down, place, table_world
from pinocchio import SE3
from py_trees.common import Status
from solid_world import box

from behaviours import Region
from behaviours.core.motion import Progress
from behaviours.core.parameter_types import ToolPose
from behaviours.grasp import Grasp
from behaviours.navigate import Navigate
from behaviours.place import Place
from behaviours.retreat_check import RetreatCheck
from controller import KinematicState, PoseGoal
from hw import TaskTime
from hw.sim import World
from robots import Geom

HIGH = 0.9
ON_HIGH = Region(
    name="high table",
    mTr=SE3(np.eye(3), np.array([0.0, 2.0, HIGH + 0.1])),
    size=np.array([0.6, 0.4, 0.2]),
)


def held_among(*fixtures: Geom) -> Harness:
    """The hand holds a block over a table, and other things stand around."""
    before = table_world(block())
    harness = Harness(World([*before.fixtures, *fixtures], before.objects))
    harness.reach_over(looking_down(0.7, 0.0, TABLE_TOP + 0.12, yaw=np.pi / 2))
    down = looking_down(0.7, 0.0, TABLE_TOP + 0.03, yaw=np.pi / 2)
    harness.reach(PoseGoal(target=down, position_tolerance=0.002, straight=True))
    harness.grip(0.0)
    assert harness.world.held is not None
    harness.context.log.grip_height = 0.03
    harness.context.log.attempt(TaskTime(0.0), TaskTime(1.0))
    harness.run(RetreatCheck("retreat_check", harness.context))
    return harness


def test_a_table_higher_than_the_shoulder_is_reached_from_a_stance():
    legs = [
        box("high table/leg", (x, y, HIGH / 2.0 - 0.02), (0.02, 0.02, HIGH / 2.0 - 0.02))
        for x in (-0.57, 0.57)
        for y in (1.73, 2.27)
    ]
    harness = held_among(box("high table/top", (0.0, 2.0, HIGH - 0.02), (0.6, 0.3, 0.02)), *legs)
    there = ToolPose(name="at it", mTe=looking_down(0.0, 1.8, HIGH + 0.25, yaw=np.pi / 2))
    harness.run(Navigate("navigate", harness.context, to=there, within_m=0.1))
    leaf = Place("place", harness.context, on=ON_HIGH)
    assert harness.run(leaf, seconds=40.0) is Status.SUCCESS, leaf.feedback_message
    thing = harness.world.find("block")
    assert harness.world.resting_on(thing) == "high table"
    assert not harness.world.touches


def test_a_place_out_of_reach_is_left_for_another_and_may_be_in_reach_the_next_time():
    harness = held_among(box("shelf", (0.925, 0.0, TABLE_TOP + 0.2), (0.05, 0.06, 0.1)))
    leaf = place(harness)
    assert harness.run(leaf) is Status.SUCCESS, leaf.feedback_message
    assert leaf.feedback_message != "placed on table, place 4"  # below the shelf
    assert harness.context.log.places_blocked == {}
    assert not harness.world.touches


@pytest.mark.parametrize(("straight", "patience"), [(True, 2.0), (False, 12.0)])
def test_a_straight_way_that_leads_nowhere_is_given_up_sooner(straight, patience):
    harness = Harness(table_world())
    goal = PoseGoal(target=looking_down(0.5, 0.0, 0.8))
    state = harness.context.state
    here = KinematicState(state.oTb, state.q)
    _, report = harness.controller.step(here, goal, harness.gate.applied)
    harness.context.now.state = replace(state, qd=np.full(7, 0.1))
    progress = Progress(harness.context, straight=straight)
    begun = harness.clock.now()
    while not progress.is_stuck(report):
        harness.clock.sleep_until(harness.clock.now() + 0.05)
    assert harness.clock.now() - begun == pytest.approx(patience, abs=0.2)


def test_a_grasp_out_of_reach_from_here_is_reached_from_elsewhere():
    """The table stands on the floor, and its far corner is too far from its front."""
    harness = Harness(table_world(block(x=1.05, y=0.28)))
    harness.reach_over(looking_down(0.85, 0.2, TABLE_TOP + 0.35))
    corner = SE3(np.eye(3), np.array([1.05, 0.25, TABLE_TOP + 0.1]))
    within = Region(name="corner", mTr=corner, size=np.array([0.2, 0.2, 0.2]))
    leaf = Grasp("grasp", harness.context, within=within)
    assert harness.run(leaf) is Status.SUCCESS, leaf.feedback_message
    assert harness.world.held is not None
    assert not harness.world.touches
    assert np.linalg.norm(harness.robot.read().oTb.translation[:2]) > 0.5


def test_a_base_that_is_stuck_beside_something_backs_off_and_tries_again():
    harness = Harness(table_world())
    harness.reach_over(looking_down(0.7, 0.0, TABLE_TOP + 0.04))
    before = harness.robot.read().oTb.translation
    there = ToolPose(name="over there", mTe=looking_down(0.7, 0.3, TABLE_TOP + 0.04))
    leaf = Navigate("navigate", harness.context, to=there)
    harness.robot.stuck = True
    while leaf.feedback_message != "backing off":
        harness.tick(leaf)
        assert leaf.status is Status.RUNNING
    harness.robot.stuck = False
    farthest = 0.0
    while harness.run(leaf, seconds=0.1) is Status.RUNNING:
        away = harness.robot.read().oTb.translation - before
        farthest = max(farthest, np.linalg.norm(away))
    assert farthest > 0.2
    assert leaf.status is Status.SUCCESS, leaf.feedback_message
