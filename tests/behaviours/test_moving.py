"""The behaviours that only move: recover, navigate, retreat_check, place, the fingers."""

import re

import numpy as np
import pytest
from pinocchio import SE3
from py_trees.common import Status
from stage import BUTTON, ON_TABLE, REFLEX, TABLE_TOP, Stage, block, looking_down, table_world

from behaviours import BasePose, Leaf, Posture, Region, ToolPose
from behaviours.fingers import HoldingObject, OpenGripper
from behaviours.navigate import Navigate
from behaviours.place import Place, places
from behaviours.recover import Recover
from behaviours.retreat_check import RetreatCheck
from behaviours.small import Wait
from controller import READY, PoseGoal

POSE = ToolPose(name="over_there", wTe=looking_down(1.6, 0.3, 0.8))
FOLDED = Posture(name="folded", q=READY + np.array([0.4, -0.3, 0.0, -0.3, 0.0, 0.2, 0.0]))


def held_block_stage() -> Stage:
    """The hand holds a block, 0.2 m above the table."""
    stage = Stage(table_world(block()))
    grip = looking_down(0.7, 0.0, TABLE_TOP + 0.03, yaw=np.pi / 2)
    stage.run(navigate(stage, ToolPose(name="block", wTe=grip), tolerance_check=False))
    stage.robot.grip(0.0, 20.0)
    stage.run_for(None, 1.0)
    assert stage.world.held is not None
    stage.context.log.grip_height = 0.03
    stage.context.log.attempt(0.0, 1.0)
    return stage


def navigate(stage: Stage, to: ToolPose | BasePose, tolerance_check: bool = True) -> Navigate:
    return Navigate("navigate", stage.context, to=to)


# navigate


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_navigate_brings_the_hand_to_a_pose(robot):
    stage = Stage(robot=robot)
    leaf = navigate(stage, POSE)
    assert stage.run(leaf) is Status.SUCCESS
    assert leaf.feedback_message == "at over_there"
    error = stage.context.wTe.translation - POSE.wTe.translation
    assert np.linalg.norm(error) < 0.015


@pytest.mark.parametrize("place", [(-2.0, 0.0, 0.0), (0.0, -2.5, np.pi), (-1.0, 1.0, -2.0)])
def test_navigate_reaches_what_is_behind_or_beside(place):
    x, y, yaw = place
    stage = Stage(table_world())
    leaf = navigate(stage, ToolPose(name="behind", wTe=looking_down(x, y, 0.7, yaw)))
    assert stage.run(leaf) is Status.SUCCESS, leaf.feedback_message


def test_navigate_drives_the_base_alone_and_leaves_the_arm():
    stage = Stage()
    leaf = navigate(stage, BasePose(name="corner", wTb=SE3(np.eye(3), np.array([1.0, 0.5, 0.0]))))
    assert stage.run(leaf) is Status.SUCCESS
    np.testing.assert_allclose(stage.robot.read().q, READY, atol=1e-9)


def test_navigate_stops_on_a_fault_and_says_which():
    stage = Stage()
    leaf = navigate(stage, POSE)
    stage.run_for(leaf, 1.0)
    stage.robot.faults = (REFLEX,)
    stage.tick(leaf)
    assert leaf.status is Status.FAILURE
    assert leaf.feedback_message == "the arm hit something"
    stage.run_for(None, 1.5)
    assert stage.speed < 1e-3


def test_navigate_notices_that_it_is_stuck():
    stage = Stage()
    stage.robot.stuck = True
    leaf = navigate(stage, POSE)
    assert stage.run(leaf, seconds=8.0) is Status.FAILURE
    assert leaf.feedback_message.startswith("stuck on the way to over_there: 1.0")


def test_navigate_gives_up_after_its_time():
    stage = Stage()
    leaf = Navigate("navigate", stage.context, to=POSE, timeout_s=0.5)
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message.startswith("not at over_there after 0.5 s")
    assert stage.clock.now() == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize("after", [0.005, 0.3, 1.0, 2.5])
def test_a_leaf_may_be_halted_at_any_tick_and_the_robot_comes_to_rest(after):
    stage = Stage()
    leaf = navigate(stage, POSE)
    stage.run_for(leaf, after)
    leaf.stop(Status.INVALID)
    stage.run_for(None, 1.5)
    assert stage.speed < 1e-3
    assert stage.run(leaf) is Status.SUCCESS  # and it can be started again


# recover


def test_recover_clears_a_reflex_rises_and_folds_the_arm():
    stage = Stage()
    stage.robot.faults = (REFLEX,)
    before = stage.context.wTe.translation[2]
    leaf = Recover("recover", stage.context, arm=FOLDED)
    stage.run_for(leaf, 0.8)
    assert stage.context.wTe.translation[2] > before + 0.05
    assert stage.run(leaf) is Status.SUCCESS
    assert leaf.feedback_message == "arm folded"
    np.testing.assert_allclose(stage.robot.read().q, FOLDED.q, atol=0.02)


def test_recover_without_a_posture_does_nothing_to_a_healthy_robot():
    stage = Stage()
    leaf = Recover("recover", stage.context)
    stage.tick(leaf)
    assert leaf.status is Status.SUCCESS
    assert stage.speed == 0.0


def test_recover_leaves_an_emergency_stop_to_a_person():
    stage = Stage()
    stage.robot.faults = (BUTTON,)
    leaf = Recover("recover", stage.context, arm=FOLDED)
    assert stage.run(leaf) is Status.FAILURE
    assert "emergency stop pressed: clear it by hand" in leaf.feedback_message
    assert stage.speed == 0.0


def test_recover_gives_up_on_a_fault_that_comes_back():
    stage = Stage()
    stage.robot.faults, stage.robot.incurable = (REFLEX,), True
    leaf = Recover("recover", stage.context, arm=FOLDED)
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message == "cleared 3 times, and again: the arm hit something"


def test_recover_says_how_far_the_arm_came():
    stage = Stage()
    stage.robot.stuck = True
    leaf = Recover("recover", stage.context, arm=FOLDED)
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message == "arm stopped 23° before folded"


# fingers


def test_open_gripper_opens_and_waits():
    stage = Stage()
    stage.robot.grip(0.02, 20.0)
    stage.run_for(None, 1.0)
    leaf = OpenGripper("open_gripper", stage.context)
    assert stage.run(leaf) is Status.SUCCESS
    assert stage.robot.read().gripper_width >= 0.076
    stage.tick(leaf)
    assert leaf.status is Status.SUCCESS  # open already: done in one tick


def test_open_gripper_fails_on_a_fault_and_on_fingers_that_stop():
    stage = Stage()
    stage.robot.grip(0.02, 20.0)
    stage.run_for(None, 1.0)
    leaf = OpenGripper("open_gripper", stage.context)
    stage.robot.faults = (REFLEX,)
    assert stage.run(leaf) is Status.FAILURE
    stage.robot.faults = ()
    stage.tick(leaf)
    stage.robot.grip(0.03, 20.0)  # somebody else stops the fingers half way
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message == "the fingers stopped at 30 mm"


def test_fingers_that_never_stop_are_not_waited_for():
    stage = held_block_stage()
    stage.robot.restless = True
    leaf = OpenGripper("open_gripper", stage.context)
    stage.robot.grip = lambda width, force: None
    assert stage.run(leaf, seconds=5.0) is Status.FAILURE
    assert leaf.feedback_message == "the fingers still move after 3 s"
    leaf = Place("place", stage.context, on=FAR, pitch_m=0.13)
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message == "the fingers still move after 3 s"


def test_holding_object_tells_something_from_nothing():
    stage = held_block_stage()
    leaf = HoldingObject("holding_object", stage.context)
    stage.tick(leaf)
    assert leaf.status is Status.SUCCESS
    assert re.fullmatch("4[01] mm between the fingers", leaf.feedback_message)
    empty = Stage()
    leaf = HoldingObject("holding_object", empty.context)
    empty.tick(leaf)
    assert leaf.status is Status.FAILURE


# retreat_check


def test_retreat_check_lifts_what_is_held():
    stage = held_block_stage()
    leaf = RetreatCheck("retreat_check", stage.context)
    assert stage.run(leaf) is Status.SUCCESS
    assert re.fullmatch("holding something 4[01] mm wide", leaf.feedback_message)
    assert stage.world.find("block").pose.translation[2] > TABLE_TOP + 0.17


def test_retreat_check_fails_when_the_fingers_closed_fully():
    stage = Stage()
    stage.robot.grip(0.0, 20.0)
    stage.run_for(None, 1.0)
    leaf = RetreatCheck("retreat_check", stage.context)
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message == "the fingers closed on nothing"


@pytest.mark.parametrize("half_width", [0.010, 0.030])
def test_retreat_check_fails_when_the_object_slips_on_the_way_up(half_width):
    """What is too heavy slips, and the fingers may still be closing when the hand is up."""
    stage = Stage(table_world(block(half=(half_width, 0.03, 0.025), mass=20.0)))
    grip = looking_down(0.7, 0.0, TABLE_TOP + 0.03, yaw=np.pi / 2)
    stage.reach(PoseGoal(wTe=looking_down(0.7, 0.0, TABLE_TOP + 0.15, yaw=np.pi / 2)))
    stage.reach(PoseGoal(wTe=grip, position_tolerance=0.002))
    stage.robot.grip(0.0, 20.0)
    stage.run_for(None, 1.0)
    assert stage.robot.read().gripper_width == pytest.approx(2.0 * half_width, abs=0.003)
    leaf = RetreatCheck("retreat_check", stage.context, rise_m=0.1)
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message == "the fingers closed on nothing"


def test_retreat_check_fails_on_a_fault_of_the_arm():
    stage = held_block_stage()
    leaf = RetreatCheck("retreat_check", stage.context)
    stage.run_for(leaf, 0.1)
    stage.robot.faults = (REFLEX,)
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message == "the arm hit something"


def test_retreat_check_fails_when_the_hand_does_not_rise():
    stage = held_block_stage()
    stage.robot.stuck = True
    leaf = RetreatCheck("retreat_check", stage.context)
    assert stage.run(leaf) is Status.FAILURE
    assert "stuck" in leaf.feedback_message


# place


FAR = Region(
    name="table",
    wTr=SE3(np.eye(3), np.array([0.85, 0.0, TABLE_TOP + 0.1])),
    size=np.array([0.3, 0.4, 0.2]),
)


def test_place_sets_the_object_down_where_it_is_free():
    stage = held_block_stage()
    stage.run(RetreatCheck("retreat_check", stage.context))
    leaf = Place("place", stage.context, on=FAR, pitch_m=0.13)
    assert stage.run(leaf) is Status.SUCCESS
    assert leaf.feedback_message == "placed on table, place 1"
    thing = stage.world.find("block")
    assert stage.world.resting_on(thing) == "table"
    np.testing.assert_allclose(thing.pose.translation[:2], places(FAR, 0.13)[0][:2], atol=0.02)
    assert stage.context.log.placed == 1
    assert stage.world.held is None


def test_places_are_a_grid_inside_the_region():
    centres = np.array(places(FAR, 0.13))
    assert len(centres) == 2 * 3
    assert FAR.contains(centres + np.array([0.0, 0.0, 1e-6])).all()
    assert centres[:, 2] == pytest.approx(TABLE_TOP)


def test_place_fails_without_anything_to_place():
    stage = Stage()
    stage.robot.grip(0.0, 20.0)
    stage.run_for(None, 1.0)
    leaf = Place("place", stage.context, on=ON_TABLE, pitch_m=0.13)
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message == "nothing left between the fingers"


def test_place_fails_when_every_place_is_taken():
    stage = held_block_stage()
    stage.context.log.places_used["table"] = 9
    leaf = Place("place", stage.context, on=ON_TABLE, pitch_m=0.13)
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message == "all 9 places on table are taken"


def test_place_fails_on_a_fault_and_when_it_cannot_get_there():
    stage = held_block_stage()
    leaf = Place("place", stage.context, on=FAR, pitch_m=0.13)
    stage.run_for(leaf, 0.1)
    stage.robot.faults = (REFLEX,)
    assert stage.run(leaf) is Status.FAILURE
    stage.robot.faults, stage.robot.stuck = (), True
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message.startswith("over the place: stuck 0.")


# small ones


def test_wait_takes_its_time():
    stage = Stage()
    leaf = Wait("wait", stage.context, duration_s=0.5)
    assert stage.run(leaf) is Status.SUCCESS
    assert stage.clock.now() == pytest.approx(0.51, abs=0.011)


def test_an_exception_in_a_leaf_carries_its_name():
    from behaviours import LeafCrashedError

    class Broken(Leaf):
        key = "broken"

        def update(self) -> Status:
            raise ZeroDivisionError("by zero")

    leaf = Broken("my node", Stage().context)
    with pytest.raises(LeafCrashedError, match="ZeroDivisionError: by zero") as caught:
        leaf.tick_once()
    assert caught.value.leaf == "my node"
