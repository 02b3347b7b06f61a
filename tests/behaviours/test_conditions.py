"""The conditions: each to yes, to no, and to what keeps it from knowing."""

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from ended import failure
from harness import BUTTON, REFLEX, SPOT, TABLE_TOP, block, looking_down
from pinocchio import SE3, exp3
from py_trees.common import Status
from scripted import FRANKIE, Script, up

from behaviours import BasePose, Condition, Now, Posture, ToolPose
from behaviours.conditions import (
    ArmHealthy,
    BatteryAbove,
    HoldingObject,
    Localised,
    Near,
)
from behaviours.seen import ObjectVisible, ObstacleWithin
from behaviours.wait import Wait
from frankie_task.testing import trial
from hw import LaserScan
from hw.sim import SimObject

READY, LASER = FRANKIE.arm.ready, FRANKIE.laser


def asked(script: Script, condition: Condition, **reading) -> tuple[bool | None, str]:
    """The answer to a reading, None if it is not known, and what is said about it."""
    script.reads(**reading)
    condition.tick_once()
    known = {Status.SUCCESS: True, Status.FAILURE: False}
    return known.get(condition.status), condition.feedback_message.removeprefix("not known: ")


def answers(script: Script, *conditions: Condition) -> list[bool | None]:
    """In the next tick."""
    script.reads()
    return [asked(script, condition, after=0.0)[0] for condition in conditions]


def test_arm_healthy_sees_every_fault():
    script = Script()
    condition = ArmHealthy("arm_healthy", script.context)
    assert asked(script, condition) == (True, "no fault")
    told = "the arm hit something; emergency stop pressed"
    assert asked(script, condition, faults=(REFLEX, BUTTON)) == (False, told)


def test_a_battery_is_above_what_is_asked_for():
    script = Script()
    condition = BatteryAbove("battery_above", script.context, percent=80.0)
    assert asked(script, condition)[0] is None
    assert asked(script, condition, battery=0.801) == (True, "battery at 80.1 %")
    assert asked(script, condition, battery=0.8) == (False, "battery at 80.0 %")


def test_near_is_about_the_hand_for_a_tool_pose():
    script = Script()
    pose = ToolPose(name="spot", mTe=up(0.3))
    assert asked(script, Near("near", script.context, pose=pose, within_m=0.31))[0]
    assert asked(script, Near("near", script.context, pose=pose, within_m=0.29)) == (
        False,
        "0.30 m, 0° from spot",
    )
    for off, answer in ((0.099, True), (0.101, False)):  # ten centimetres, if nothing is said
        near = Near("near", script.context, pose=ToolPose(name="spot", mTe=up(off)))
        assert asked(script, near)[0] is answer


@pytest.mark.parametrize(("within_deg", "answer"), [(None, True), (89.0, False)])
def test_near_is_about_the_base_for_a_base_pose_and_its_heading_if_asked(within_deg, answer):
    script = Script()
    oTb = SE3(pin.utils.rotate("z", np.pi / 2), np.array([0.3, 0.4, 0.0]))
    condition = Near(
        "near",
        script.context,
        pose=BasePose(name="corner", mTb=oTb),
        within_m=0.51,
        within_deg=within_deg,
    )
    told = answer, "0.50 m, 90° from corner"
    assert asked(script, condition, after=0.3, oTb=SE3.Identity()) == told


@pytest.mark.parametrize(
    ("age", "uncertainty", "status"),
    [(4.9, 0.099, Status.SUCCESS), (5.1, 0.099, Status.RUNNING), (4.9, 0.101, Status.RUNNING)],
)
def test_where_the_base_is_has_to_be_confirmed_lately_and_exactly(age, uncertainty, status):
    agreement = SimpleNamespace(fault=None, since=None)
    here = SimpleNamespace(agreement=agreement, doubt="", rival="", estimate=())
    here.uncertainty, here.confirmed = uncertainty, 10.0 - age
    now = Now(state=SimpleNamespace(stamp=10.0))
    context = SimpleNamespace(localisation=here, now=now)
    condition = Localised("localised", context)
    assert condition.update() is status
    here.rival = "a bench looks like another one"
    assert condition.update() is Status.RUNNING
    here.agreement.since = 0.0
    assert condition.update() is Status.RUNNING
    assert condition.feedback_message == "not known: nothing in sight is where the map has it"
    here.doubt = "a wall is not there"
    assert condition.update() is Status.FAILURE


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
        beams = np.arange(len(scan.ranges))  # a degree apart
        taped, dirty, short, open_hall = (
            replace(scan, ranges=np.where(abs(beams - 60) <= half, told, scan.ranges))
            for half, told in ((1000, np.nan), (10, np.nan), (10, 0.0), (1000, np.inf))
        )
        one = replace(scan, ranges=np.where(beams % 4 == 0, scan.ranges, np.nan))  # near glass
        sees = "not known: the laser sees {} of the 240° asked about"
        for newest, age, said in (
            (scan, 0.31, "not known: no scan tells what is near"),
            (taped, 0.0, sees.format(0)),
            (dirty, 0.0, sees.format(218)),
            (short, 0.0, sees.format(218)),
            (open_hall, 0.0, "the nearest that the laser sees is out of"),
            (one, 0.0, "the nearest that the laser sees is 1."),
            (scan, 0.29, "the nearest that the laser sees is 1."),
        ):
            laser = SimpleNamespace(
                latest=lambda max_age, newest=newest, age=age: newest if age <= max_age else None
            )
            t.context.robot = SimpleNamespace(laser=laser, description=t.context.robot.description)
            ahead.update()
            assert ahead.feedback_message.startswith(said)


def test_near_compares_every_joint_for_a_posture():
    script = Script()
    bent = Posture(name="bent", q=READY + np.deg2rad([0, 0, 0, 0, 0, 0, 5.0]))
    for within, answer in ((5.1, True), (4.9, False)):
        near = Near("near", script.context, pose=bent, within_deg=within)
        assert asked(script, near) == (answer, "5.0° from bent")
    assert not asked(script, Near("near", script.context, pose=bent))[0]


def test_a_hand_holds_what_its_fingers_rest_on_and_what_a_leaf_lets_go_of():
    script = Script()
    script.holds()
    condition = HoldingObject("holding_object", script.context)
    assert answers(script, condition) == [True]
    assert condition.feedback_message == "40 mm between the fingers"
    script.reads(width=0.045, gripper_moving=True)
    assert answers(script, condition) == [None]
    script.reads(width=0.06, gripper_moving=True)
    assert answers(script, condition) == [False]
    said = "nothing held, 60 mm between the fingers: the fingers have opened"
    assert condition.feedback_message == said
    leaf = script.context.memory.letting_go = Wait("place", script.context, duration_s=1.0)
    assert answers(script, condition) == [False]
    leaf.tick_once()
    assert answers(script, condition) == [True]
    assert condition.feedback_message == "place lets go of it"


def test_a_hand_that_has_opened_as_told_holds_nothing_however_wide_it_was():
    script = Script()
    script.holds(width=0.075)
    condition = HoldingObject("holding_object", script.context)
    assert answers(script, condition) == [True]
    condition.open_gripper()
    script.rest(width=0.08)
    assert answers(script, condition) == [False]


def nearest(x: float, y: float, blind: Sequence[int] = (), **options) -> tuple[Status, str]:
    """The answer, and what is said, where a beam of the laser sees something there from the base.

    The others, a degree apart, see nothing within reach; those of blind directions tell nothing.
    """
    script = Script()
    points = LASER.points(np.full(len(LASER.angles), 3.0))
    ranges = np.where(np.isin(np.round(np.degrees(LASER.angles)), blind), np.nan, np.inf)
    scan = LaserScan(
        stamp=0.0,
        ranges=np.append(ranges, np.hypot(x, y)),
        points=np.vstack([points, [x, y, LASER.bTs.translation[2]]]),
        oTb=SE3.Identity(),
    )
    script.context.robot.laser = SimpleNamespace(latest=lambda max_age: scan)
    condition = ObstacleWithin("obstacle_within", script.context, **options)
    condition.tick_once()
    return condition.status, condition.feedback_message


def test_what_is_near_is_measured_from_the_outline_of_the_base():
    ahead, left = np.array(FRANKIE.base.size[:2]) / 2.0
    for x, y in ((ahead + 0.5, 0.0), (ahead + 0.3, -left - 0.4), (0.0, left + 0.5)):
        for within, answer in ((0.51, Status.SUCCESS), (0.49, Status.FAILURE)):
            assert nearest(x, y, distance_m=within, sector_deg=240.0) == (
                answer,
                "the nearest that the laser sees is 0.50 m away",
            )


def test_a_sector_is_asked_about_as_seen_from_the_laser():
    for turn, answer in ((29.0, True), (-29.0, True), (-31.0, False)):
        ahead = LASER.bTs.act(exp3(np.array([0.0, 0.0, np.radians(turn)])) @ [1.0, 0.0, 0.0])
        status, _ = nearest(*ahead[:2], distance_m=0.99, sector_deg=60.0)
        assert status is (Status.SUCCESS if answer else Status.FAILURE)


@pytest.mark.parametrize(
    ("sector", "blind", "sees"),
    [
        (249.0, (), None),
        (251.0, (), 240),  # its last beams go 120 degrees to either side
        (360.0, (), 240),
        (240.0, (8, 9, 10, 11), None),
        (240.0, (8, 9, 10, 11, 12), 234),
    ],
)
def test_what_is_near_is_not_known_where_more_than_five_degrees_are_not_seen(sector, blind, sees):
    status, said = nearest(2.0, 0.0, blind, distance_m=0.1, sector_deg=sector)
    assert status is (Status.FAILURE if sees is None else Status.RUNNING)
    if sees is not None:
        assert said.startswith(f"not known: the laser sees {sees} of the {sector:g}°")
    assert nearest(0.5, 0.0, blind, distance_m=0.2, sector_deg=sector)[0] is Status.SUCCESS


def over_the_spot(*objects: SimObject) -> Script:
    """The camera looks at it from above."""
    return Script(hand=looking_down(0.68, 0.0, TABLE_TOP + 0.35)).shows(*objects)


def test_object_visible_answers_anew_when_the_object_is_gone_and_when_the_camera_is_blind():
    script = over_the_spot(block())
    condition = ObjectVisible("object_visible", script.context, within=SPOT)
    two = ObjectVisible("object_visible", script.context, within=SPOT, least=2)
    assert answers(script, condition, two) == [True, False]
    assert condition.feedback_message == "1 object seen in spot"
    script.shows()
    assert answers(script, condition) == [False]
    assert condition.feedback_message == "nothing over 3 mm seen in spot"
    script.seen = ()
    script.rest(s=1.1)
    assert answers(script, condition) == [None]
    assert condition.feedback_message == "not known: no camera frame"


@pytest.mark.parametrize(
    ("half", "options", "counts"),
    [
        ((0.03, 0.03), {"smallest_cm2": 30.0}, True),
        ((0.03, 0.03), {"smallest_cm2": 45.0}, False),  # it has 36
        ((0.004, 0.01), {}, True),  # 1.6 cm², of 1 cm² if nothing is said
        ((0.003, 0.003), {}, False),
    ],
)
def test_what_is_smaller_counts_as_nothing(half, options, counts):
    script = over_the_spot(block((*half, 0.02), x=0.704, y=0.004))
    visible = ObjectVisible("object_visible", script.context, within=SPOT, **options)
    assert answers(script, visible) == [counts]


def test_what_an_object_hides_may_be_another():
    script = over_the_spot(block((0.02, 0.03, 0.075), x=0.64))
    two = ObjectVisible("object_visible", script.context, within=SPOT, least=2)
    assert answers(script, two) == [None]
    assert "% of spot not seen" in two.feedback_message


def test_a_region_behind_the_camera_is_not_an_empty_one():
    elsewhere = replace(SPOT, mTr=SE3(np.eye(3), np.array([-3.0, 0.0, TABLE_TOP + 0.1])))
    script = over_the_spot(block())
    condition = ObjectVisible("object_visible", script.context, within=elsewhere)
    assert answers(script, condition) == [None]
    assert condition.feedback_message == "not known: spot is out of view"


def test_a_condition_judges_the_newest_picture_though_another_has_fetched_it():
    """Not the newest that a condition has used: that may be of any age."""
    script = over_the_spot()
    asked_before, asked_later = (
        ObjectVisible("object_visible", script.context, within=SPOT) for _ in range(2)
    )
    assert answers(script, asked_before) == [False]
    script.shows(block())
    script.reads(after=1.0)
    script.context.vision.newest(np.inf)
    script.reads(after=0.01)
    assert answers(script, asked_before, asked_later) == [True, True]
