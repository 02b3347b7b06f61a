"""The conditions: each to yes, to no, and to what keeps it from knowing."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from ended import failure
from harness import BUTTON, REFLEX, SPOT, TABLE_TOP, Harness, block, over_the_table, table_world
from pinocchio import SE3
from py_trees.common import Status

from behaviours import BasePose, Condition, Posture, ToolPose
from behaviours.conditions import ArmAt, ArmHealthy, BatteryAbove, Near, TimeBetween
from behaviours.seen import ObjectVisible, ObstacleWithin, RegionFree
from frankie_task.testing import trial
from hw.sim.body import Dynamics
from robots import load_robot

READY = load_robot("frankie").arm.ready


def asked(harness: Harness, condition: Condition) -> tuple[bool | None, str]:
    """The answer, None if it is not known, and what is said about it."""
    harness.tick(condition)
    answers = {Status.SUCCESS: True, Status.FAILURE: False, Status.RUNNING: None}
    return answers[condition.status], condition.feedback_message.removeprefix("not known: ")


def test_arm_healthy_sees_every_fault():
    harness = Harness(table_world())
    condition = ArmHealthy("arm_healthy", harness.context)
    assert asked(harness, condition) == (True, "no fault")
    harness.robot.faults = (REFLEX, BUTTON)
    assert asked(harness, condition) == (False, "the arm hit something; emergency stop pressed")


def test_the_battery_runs_down_with_the_time():
    harness = Harness(table_world(), dynamics=Dynamics(battery_life=5.0))
    condition = BatteryAbove("battery_above", harness.context, percent=80.0)
    assert asked(harness, condition) == (True, "battery at 100.0 %")
    harness.run_for(None, 0.75)
    assert asked(harness, condition)[0]
    harness.run_for(None, 0.5)
    answer, text = asked(harness, condition)
    assert not answer
    assert text.startswith("battery at 74.")
    harness.run_for(None, 5.0)
    assert asked(harness, condition) == (False, "battery at 0.0 %")


def test_near_is_about_the_hand_for_a_tool_pose():
    harness = Harness(table_world())
    x, y, z = harness.context.wTe.translation
    harness.tick(None)
    rotation = harness.context.wTe.rotation
    pose = ToolPose(name="spot", mTe=SE3(rotation, np.array([x, y, z + 0.3])))
    assert asked(harness, Near("near", harness.context, pose=pose, within_m=0.31))[0]
    assert asked(harness, Near("near", harness.context, pose=pose, within_m=0.29)) == (
        False,
        "0.30 m, 0° from spot",
    )


@pytest.mark.parametrize(("within_deg", "answer"), [(None, True), (89.0, False)])
def test_near_is_about_the_base_for_a_base_pose_and_its_heading_if_asked(within_deg, answer):
    harness = Harness(table_world())
    wTb = SE3(pin.utils.rotate("z", np.pi / 2), np.array([0.3, 0.4, 0.0]))
    condition = Near(
        "near",
        harness.context,
        pose=BasePose(name="corner", mTb=wTb),
        within_m=0.51,
        within_deg=within_deg,
    )
    assert asked(harness, condition) == (answer, "0.50 m, 90° from corner")


@pytest.mark.parametrize(
    ("after", "before", "answer"),
    [("08:00", "12:00", False), ("08:00", "12:01", True), ("22:00", "06:00", False)],
)
def test_a_simulated_run_begins_at_noon(after, before, answer):
    with trial("single") as t:
        condition = TimeBetween("time_between", t.context, after=after, before=before)
        assert t.run(condition) is (Status.SUCCESS if answer else Status.FAILURE)
        assert condition.feedback_message == "it is 12:00"
    t.context.began_at = 3600.0
    condition.tick_once()
    assert condition.status is (Status.SUCCESS if after > before else Status.FAILURE)


def test_what_the_laser_does_not_see_is_not_free():
    with trial("single") as t:  # whose table stands 1.05 m from the base
        near = ObstacleWithin("obstacle_within", t.context, distance_m=0.8)
        assert failure(t, near) == (
            "not known: the laser sees 240 of the 360° asked about; `sector_deg` asks about less"
        )
        ahead = ObstacleWithin("ahead", t.context, distance_m=0.8, sector_deg=240.0)
        assert failure(t, ahead).startswith("the nearest that the laser sees is 1.")
        assert t.run(ObstacleWithin("far", t.context, distance_m=1.2)) is Status.SUCCESS
        scan = t.context.robot.laser.latest(1.0)
        dark = replace(scan, ranges=np.full_like(scan.ranges, np.nan))
        for newest, why in ((None, "no scan tells what is near"), (dark, "no beam of the laser")):
            laser = SimpleNamespace(latest=lambda max_age, newest=newest: newest)
            t.context.robot = SimpleNamespace(laser=laser, description=t.context.robot.description)
            assert ahead.update() is Status.RUNNING
            assert ahead.feedback_message.startswith(f"not known: {why}")


def test_arm_at_compares_every_joint():
    harness = Harness(table_world())
    bent = Posture(name="bent", q=READY + np.deg2rad([0, 0, 0, 0, 0, 0, 5.0]))
    assert asked(harness, ArmAt("arm_at", harness.context, posture=bent)) == (
        False,
        "5.0° from bent",
    )
    assert asked(harness, ArmAt("arm_at", harness.context, posture=bent, within_deg=5.1))[0]


def test_object_visible_answers_anew_when_the_object_is_gone_and_when_the_camera_is_blind():
    harness = over_the_table(block())
    condition = ObjectVisible("object_visible", harness.context, within=SPOT)
    two = ObjectVisible("object_visible", harness.context, within=SPOT, least=2)
    free = RegionFree("region_free", harness.context, region=SPOT)
    assert [asked(harness, one)[0] for one in (condition, two, free)] == [True, False, False]
    large = RegionFree("region_free", harness.context, region=SPOT, smallest_cm2=500.0)
    assert asked(harness, large)[0]
    harness.world.objects.clear()
    harness.run_for(None, 0.2)
    assert [asked(harness, one)[0] for one in (condition, free)] == [False, True]
    harness.robot.blind = True
    harness.run_for(None, 0.3)
    assert asked(harness, condition) == asked(harness, free) == (None, "no camera frame")


def test_a_region_behind_the_camera_is_not_an_empty_one():
    harness = Harness(table_world(block()))
    elsewhere = replace(SPOT, mTr=SE3(np.eye(3), np.array([-3.0, 0.0, TABLE_TOP + 0.1])))
    condition = ObjectVisible("object_visible", harness.context, within=elsewhere)
    assert asked(harness, condition) == (None, "spot is out of view")
    free = RegionFree("region_free", harness.context, region=elsewhere)
    assert asked(harness, free) == (None, "spot is out of view")


def test_a_condition_judges_the_newest_picture_though_another_has_fetched_it():
    """Not the newest that a condition has used: that may be of any age."""
    harness = over_the_table()
    vision = harness.context.vision
    free = RegionFree("region_free", harness.context, region=SPOT)
    there = ObjectVisible("object_visible", harness.context, within=SPOT)
    assert asked(harness, free) == (True, "nothing over 3 mm seen in spot")
    harness.world.objects.append(block())
    harness.run_for(None, 1.0)
    before = vision.newest(-np.inf)
    while vision.newest(np.inf) is before:  # there is no newer one in the next tick
        harness.tick(None)
    assert asked(harness, free) == (False, "1 object seen in spot")
    assert asked(harness, there)[0]
