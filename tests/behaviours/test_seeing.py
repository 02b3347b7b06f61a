"""The behaviours that look: grasp and region_empty, with the real network on rendered frames."""

import re
from dataclasses import replace

import numpy as np
import pytest
from ended import failure
from harness import (
    SPOT,
    TABLE_TOP,
    Harness,
    block,
    looking_down,
    over_the_table,
    table_world,
    with_the_hand_at,
)
from pinocchio import SE3, log3
from py_trees.common import Status
from scripted import HERE, Script, up

from behaviours import Region, ToolPose
from behaviours.grasp import Grasp
from behaviours.navigate import Navigate
from behaviours.region_empty import RegionEmpty
from hw.sim import SimObject
from perception import GraspEstimate
from robots import Cylinder, Geom


def looking_stage(*objects: SimObject) -> Harness:
    """The hand 0.35 m above the table, looking at the region, after it has driven there."""
    harness = Harness(table_world(*objects))
    pose = ToolPose(name="above", mTe=looking_down(0.68, 0.0, TABLE_TOP + 0.35))
    assert harness.run(Navigate("navigate", harness.context, to=pose)) is Status.SUCCESS
    return harness


def grasp(harness: Harness, **options) -> Grasp:
    return Grasp("grasp", harness.context, within=SPOT, **options)


def test_grasp_finds_follows_and_holds_a_block():
    harness = over_the_table(block(x=0.70, y=0.06))
    leaf = grasp(harness)
    harness.run_into(leaf, "close")
    closing_from = harness.context.oTe.translation[2]
    assert harness.run(leaf) is Status.SUCCESS
    # What is held would be pressed on the table.
    assert harness.context.oTe.translation[2] > closing_from - 0.001
    assert harness.world.held is harness.world.find("block")
    assert harness.context.log.attempts == 1
    assert 0.005 < harness.context.log.grip_height < 0.05
    assert leaf.feedback_message.startswith("closed at ")


def test_the_goal_follows_an_object_that_is_moved_until_it_is_locked():
    harness = over_the_table(block(x=0.75, y=0.0))
    leaf = grasp(harness)
    harness.run_for(leaf, 0.3)
    assert not harness.context.vision.tracker.locked
    harness.world.find("block").pose.translation = np.array([0.77, 0.02, TABLE_TOP + 0.025])
    assert harness.run(leaf) is Status.SUCCESS
    assert harness.world.held is harness.world.find("block")


def test_the_hand_goes_down_only_when_it_stands_over_the_grasp():
    harness = over_the_table(block(half=(0.02, 0.03, 0.025), x=0.82, y=0.09))
    leaf = grasp(harness, lock_distance_m=0.45)  # locked long before the hand is there
    harness.run_into(leaf, "descend")
    oTg = harness.context.vision.grasp.oTg
    error = oTg.actInv(harness.context.oTe)
    assert np.linalg.norm(error.translation[:2]) <= 0.009 + 1e-3
    assert np.linalg.norm(log3(error.rotation)) <= np.deg2rad(3.0) + 0.01


def test_a_grasp_out_of_the_region_is_not_taken():
    harness = over_the_table(block(x=0.66, y=0.0))
    pose = SE3(np.eye(3), np.array([0.85, 0.0, TABLE_TOP + 0.1]))
    elsewhere = Region(name="elsewhere", mTr=pose, size=np.array([0.15, 0.2, 0.2]))
    leaf = Grasp("grasp", harness.context, within=elsewhere)
    assert failure(harness, leaf).startswith("no grasp for 1.5 s: ")
    assert harness.context.log.attempts == 0


def test_a_grasp_may_be_halted_at_any_tick():
    harness = over_the_table(block())
    leaf = grasp(harness)
    harness.run_for(leaf, 1.0)
    leaf.stop(Status.INVALID)
    harness.run_for(None, 1.0)
    assert harness.speed < 1e-3
    assert harness.context.vision.grasp is None


def highest_view(harness: Harness, leaf: Grasp, x: float, y: float) -> float:
    """Run a leaf; how high the camera looked down from over a place on the table [m]; 0: never."""
    highest = 0.0
    while leaf.status is not Status.SUCCESS and leaf.status is not Status.FAILURE:
        harness.tick(leaf)
        oTc = harness.context.oTe * harness.context.robot.description.camera.eTc
        away = oTc.translation - np.array([x, y, TABLE_TOP])
        if np.linalg.norm(away[:2]) < 0.05 and oTc.rotation[2, 2] < -0.99:
            highest = max(highest, away[2])
    return highest


def test_where_no_grasp_is_seen_the_camera_looks_again_from_above():
    parts = (Geom(Cylinder(0.06, 0.03), SE3.Identity(), "tin"),)
    harness = looking_stage(replace(block((0.06, 0.06, 0.03), x=0.80, y=0.08), parts=parts))
    leaf = grasp(harness)
    harness.tick(leaf)
    assert highest_view(harness, leaf, 0.80, 0.08) > 0.38
    assert leaf.status is Status.FAILURE
    assert "the hand does not fit" in leaf.feedback_message


def test_a_hand_looks_again_before_it_goes_down_on_a_doubtful_grasp(monkeypatch):
    harness = over_the_table(block(x=0.75, y=0.05))
    monkeypatch.setattr("behaviours.views.grasp_target.DOUBTFUL", 1.1)
    leaf = grasp(harness)
    harness.tick(leaf)
    assert highest_view(harness, leaf, 0.75, 0.05) > 0.38
    assert leaf.status is Status.SUCCESS
    assert harness.world.held is harness.world.find("block")


def test_an_empty_region_is_seen_to_be_empty():
    harness = over_the_table()
    leaf = RegionEmpty("region_empty", harness.context, region=SPOT)
    assert harness.run(leaf) is Status.SUCCESS
    assert re.fullmatch(
        r"nothing over \d mm(, no flat cover over \d+ mm)?, on the 100 % seen",
        leaf.feedback_message,
    )
    assert harness.clock.now() > 0.2


def test_a_region_with_something_in_it_is_not_empty():
    harness = looking_stage(block(half=(0.02, 0.03, 0.0015)))
    leaf = RegionEmpty("region_empty", harness.context, region=SPOT)
    assert harness.run(leaf) is Status.FAILURE
    area = float(leaf.feedback_message.split()[0])
    assert area == pytest.approx(24.0, abs=6.0)  # 4 cm x 6 cm, and what noise adds


def test_a_region_is_counted_where_the_map_has_it_in_the_end():
    harness = looking_stage(block(y=0.215, half=(0.02, 0.02, 0.02)))  # just outside
    here = harness.context.localisation
    here.oTm = SE3(np.eye(3), np.array([0.0, 0.03, 0.0]))  # just after a jump
    leaf = RegionEmpty("region_empty", harness.context, region=replace(SPOT, frame=here))
    harness.run_for(leaf, 0.08)
    assert leaf.status is Status.RUNNING
    here.oTm = None
    assert harness.run(leaf) is Status.SUCCESS
    assert harness.context.log.stocks["spot"].most == 0


@pytest.mark.parametrize("things", [0, 1])
def test_what_is_not_in_the_picture_is_looked_at_from_another_view(things):
    world = table_world(*[block(x=0.85, y=0.1)] * things)
    harness = with_the_hand_at(world, 0.5, -0.4, TABLE_TOP + 0.3)
    leaf = RegionEmpty("region_empty", harness.context, region=SPOT)
    harness.run_for(leaf, 0.5)
    assert leaf.status is Status.RUNNING
    assert harness.run(leaf) is (Status.FAILURE if things else Status.SUCCESS)


def test_a_blind_camera_does_not_make_a_region_empty():
    harness = over_the_table()
    harness.robot.blind = True
    leaf = RegionEmpty("region_empty", harness.context, region=SPOT)
    assert failure(harness, leaf) == "no camera frame"


def test_the_base_comes_nearer_to_where_a_moving_object_is_now(
    monkeypatch,
):
    script = Script()
    leaf = Grasp("grasp", script.context, within=SPOT)
    seen = GraspEstimate(
        oTg=up(-0.1),
        width=0.04,
        quality=0.9,
        stamp=0.0,
        pixel=(0.0, 0.0),
        angle=0.0,
        opening=0.08,
        velocity=np.array([0.1, 0.0, 0.0]),
    )
    monkeypatch.setattr(leaf._sought, "track", lambda now: seen)
    for _ in range(2):
        script.reads(after=0.2)
        leaf.tick_once()
        script.report(away=0.5, unreachable="out of reach")
    assert leaf.feedback_message == "setting out for a stance nearer to it"
    along = HERE.translation + np.array([0.04, 0.0, -0.1 + 0.24])
    np.testing.assert_allclose(script.goal.target.translation, along)
