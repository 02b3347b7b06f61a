"""The conditions: each to yes, to no, and to what keeps it from knowing."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from pinocchio import SE3
from py_trees.common import Status
from stage import BUTTON, REFLEX, TABLE_TOP, Stage, block, looking_down, table_world

from behaviours import BasePose, Condition, Posture, Region, ToolPose
from behaviours.conditions import ArmAt, ArmHealthy, BatteryAbove, Near, ObjectVisible
from controller import READY
from hw.sim.robot import Dynamics


def asked(stage: Stage, condition: Condition) -> tuple[bool, str]:
    """The answer and what is said about it."""
    stage.tick(condition)
    assert condition.status in (Status.SUCCESS, Status.FAILURE)
    return condition.status is Status.SUCCESS, condition.feedback_message


def test_arm_healthy_sees_every_fault():
    stage = Stage()
    condition = ArmHealthy("arm_healthy", stage.context)
    assert asked(stage, condition) == (True, "no fault")
    stage.robot.faults = (REFLEX, BUTTON)
    assert asked(stage, condition) == (False, "the arm hit something; emergency stop pressed")


def test_the_battery_runs_down_with_the_time():
    stage = Stage()
    stage.robot._dynamics = Dynamics(battery_life=10.0)
    condition = BatteryAbove("battery_above", stage.context, percent=80.0)
    assert asked(stage, condition) == (True, "battery at 100.0 %")
    stage.run_for(None, 1.5)
    assert asked(stage, condition)[0]
    stage.run_for(None, 1.0)
    answer, text = asked(stage, condition)
    assert not answer
    assert text.startswith("battery at 74.")
    stage.run_for(None, 10.0)
    assert asked(stage, condition) == (False, "battery at 0.0 %")


def test_a_robot_that_does_not_tell_its_charge_has_none():
    stage = Stage()
    stage.robot.read = lambda: replace(type(stage.robot).read(stage.robot), battery=None)
    answer, text = asked(stage, BatteryAbove("battery_above", stage.context, percent=0.0))
    assert not answer
    assert text == "the robot does not tell the charge of its battery"


def test_near_is_about_the_hand_for_a_tool_pose():
    stage = Stage()
    x, y, z = stage.context.wTe.translation
    stage.tick(None)
    rotation = stage.context.wTe.rotation
    pose = ToolPose(name="spot", wTe=SE3(rotation, np.array([x, y, z + 0.3])))
    assert asked(stage, Near("near", stage.context, pose=pose, within_m=0.31))[0]
    assert asked(stage, Near("near", stage.context, pose=pose, within_m=0.29)) == (
        False,
        "0.30 m, 0° from spot",
    )


@pytest.mark.parametrize(("within_deg", "answer"), [(None, True), (91.0, True), (89.0, False)])
def test_near_is_about_the_base_for_a_base_pose_and_its_heading_if_asked(within_deg, answer):
    stage = Stage()
    wTb = SE3(pin.utils.rotate("z", np.pi / 2), np.array([0.3, 0.4, 0.0]))
    condition = Near(
        "near",
        stage.context,
        pose=BasePose(name="corner", wTb=wTb),
        within_m=0.51,
        within_deg=within_deg,
    )
    assert asked(stage, condition) == (answer, "0.50 m, 90° from corner")


def test_arm_at_compares_every_joint():
    stage = Stage()
    bent = Posture(name="bent", q=READY + np.deg2rad([0, 0, 0, 0, 0, 0, 5.0]))
    assert asked(stage, ArmAt("arm_at", stage.context, posture=bent)) == (False, "5.0° from bent")
    assert asked(stage, ArmAt("arm_at", stage.context, posture=bent, within_deg=5.1))[0]


SPOT = Region(
    name="spot",
    wTr=SE3(np.eye(3), np.array([0.75, 0.0, TABLE_TOP + 0.1])),
    size=np.array([0.4, 0.4, 0.2]),
)


def test_object_visible_tells_an_object_from_an_empty_table():
    for objects, answer in (((), False), ((block(),), True)):
        stage = Stage(table_world(*objects))
        stage.reach_over(looking_down(0.68, 0.0, TABLE_TOP + 0.35))
        condition = ObjectVisible("object_visible", stage.context, within=SPOT)
        for _ in range(30):
            assert asked(stage, condition) == (answer, f"{len(objects)} things seen in spot")


def test_object_visible_answers_anew_when_the_object_is_gone():
    stage = Stage(table_world(block()))
    stage.reach_over(looking_down(0.68, 0.0, TABLE_TOP + 0.35))
    condition = ObjectVisible("object_visible", stage.context, within=SPOT)
    assert asked(stage, condition)[0]
    stage.world.objects.clear()
    stage.run_for(None, 0.2)
    assert not asked(stage, condition)[0]


def test_a_region_behind_the_camera_is_not_an_empty_one():
    stage = Stage(table_world(block()))
    elsewhere = replace(SPOT, wTr=SE3(np.eye(3), np.array([-3.0, 0.0, TABLE_TOP + 0.1])))
    condition = ObjectVisible("object_visible", stage.context, within=elsewhere)
    assert asked(stage, condition) == (False, "spot is out of view")


def test_a_blind_camera_sees_nothing():
    stage = Stage(table_world(block()))
    stage.reach_over(looking_down(0.68, 0.0, TABLE_TOP + 0.35))
    condition = ObjectVisible("object_visible", stage.context, within=SPOT)
    assert asked(stage, condition)[0]
    stage.robot.blind = True
    stage.run_for(None, 0.3)
    assert asked(stage, condition) == (False, "no camera frame")


def test_two_leaves_of_one_tick_see_the_same_frame():
    stage = Stage(table_world(block()))
    stage.run_for(None, 0.1)
    eyes = stage.context.eyes
    eyes.begin_tick()
    first = eyes.new_frame()
    assert first is not None
    assert eyes.new_frame() is first
    eyes.begin_tick()
    assert eyes.new_frame() is None
    assert eyes.frame is first
