"""The behaviours that only move: recover, navigate, drive, move_arm."""

from dataclasses import replace
from math import atan2, degrees

import numpy as np
import pinocchio as pin
import pytest
from ended import failure, success
from harness import BUTTON, REFLEX, Harness, looking_down, table_world
from pinocchio import SE3
from py_trees.common import Status

from behaviours import BasePose, Posture, ToolPose
from behaviours.drive import Drive
from behaviours.move_arm import MoveArm
from behaviours.navigate import Navigate
from behaviours.recover import Recover
from hw.sim import World
from robots import Box, Geom, Plane, load_robot

READY = load_robot("frankie").arm.ready


TO_THE_LEFT = Posture(name="to the left", q=READY + np.array([0.9, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]))


POSE = ToolPose(name="over_there", mTe=looking_down(1.6, 0.3, 0.8))


FOLDED = Posture(name="folded", q=READY + np.array([0.4, -0.3, 0.0, -0.3, 0.0, 0.2, 0.0]))


def navigate(harness: Harness, to: ToolPose) -> Navigate:
    return Navigate("navigate", harness.context, to=to)


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_navigate_brings_the_hand_to_a_pose(robot):
    harness = Harness(table_world(), robot=robot)
    assert success(harness, navigate(harness, POSE)) == "at over_there"
    error = harness.context.oTe.translation - POSE.oTe.translation
    assert np.linalg.norm(error) < 0.015


def test_navigate_ends_on_the_move_where_near_is_near_enough():
    exact, near = Harness(), Harness()
    assert exact.run(navigate(exact, POSE)) is Status.SUCCESS
    assert near.run(Navigate("navigate", near.context, to=POSE, within_m=0.1)) is Status.SUCCESS
    left = np.linalg.norm(near.context.oTe.translation - POSE.oTe.translation)
    assert 0.03 < left < 0.1
    assert near.clock.now() < exact.clock.now() - 0.1


@pytest.mark.parametrize("fault", [True, False])
def test_at_a_fault_and_when_it_is_halted_the_robot_comes_to_rest(fault):
    harness = Harness(table_world())
    leaf = navigate(harness, POSE)
    harness.run_for(leaf, 1.0)
    if fault:
        harness.robot.faults = (REFLEX,)
        assert failure(harness, leaf, seconds=0.01) == "the arm hit something"
    else:
        leaf.stop(Status.INVALID)
    harness.run_for(None, 1.5)
    assert harness.speed < 1e-3
    if not fault:
        assert harness.run(leaf) is Status.SUCCESS  # and it can be started again


def test_recover_clears_a_reflex_rises_and_folds_the_arm():
    harness = Harness(table_world())
    harness.robot.faults = (REFLEX,)
    before = harness.context.oTe.translation[2]
    leaf = Recover("recover", harness.context, arm=FOLDED)
    harness.run_for(leaf, 1.3)
    assert harness.context.oTe.translation[2] > before + 0.05
    assert success(harness, leaf) == "arm folded"
    np.testing.assert_allclose(harness.robot.read().q, FOLDED.q, atol=0.02)


def test_recover_without_a_posture_does_nothing_to_a_healthy_robot():
    harness = Harness(table_world())
    leaf = Recover("recover", harness.context)
    harness.tick(leaf)
    assert leaf.status is Status.SUCCESS
    assert harness.speed == 0.0


def test_recover_leaves_an_emergency_stop_to_a_person():
    harness = Harness(table_world())
    harness.robot.faults = (BUTTON,)
    leaf = Recover("recover", harness.context, arm=FOLDED)
    assert "emergency stop pressed: clear it by hand" in failure(harness, leaf)
    assert harness.speed == 0.0


def test_recover_waits_for_a_recovery_that_takes_time():
    harness = Harness(table_world())
    harness.robot.faults, harness.robot.incurable = (REFLEX,), True
    started, read = [], harness.robot.read
    harness.robot.recover = lambda: started.append(harness.clock.now())
    harness.robot.read = lambda: replace(
        read(), recovering=bool(started) and harness.clock.now() < started[0] + 0.5
    )
    leaf = Recover("recover", harness.context)
    harness.run_for(leaf, 0.8)
    assert leaf.feedback_message == "recovering"
    assert len(started) == 1
    harness.robot.faults = ()
    assert harness.run(leaf) is Status.SUCCESS
    assert len(started) == 1
    assert harness.clock.now() >= 0.5


@pytest.mark.parametrize("room_behind", [2.0, 0.05])
def test_recover_backs_the_base_off_from_what_is_in_the_way_of_the_arm(room_behind):
    """The arm swings against a cupboard on its left, and there is no room to turn."""
    floor = Geom(Plane(), SE3.Identity(), "floor")
    cupboard = Geom(Box((0.5, 0.3, 0.55)), SE3(np.eye(3), np.array([0.75, 0.65, 0.55])), "cupboard")
    x = -0.35 - room_behind - 0.05
    wall = Geom(Box((0.05, 1.0, 0.5)), SE3(np.eye(3), np.array([x, 0.0, 0.5])), "wall")
    side = Geom(Box((1.0, 0.05, 0.15)), SE3(np.eye(3), np.array([0.0, -0.34, 0.15])), "side")
    harness = Harness(World([floor, cupboard, wall, side], []))
    leaf = Recover("recover", harness.context, arm=TO_THE_LEFT)
    outcome = harness.run(leaf)
    if room_behind > 1.0:
        assert outcome is Status.SUCCESS
        assert harness.robot.read().oTb.translation[0] < -0.2
    else:
        assert outcome is Status.FAILURE
        assert "before to the left" in leaf.feedback_message
    assert harness.robot.read().faults == ()


CORNER = BasePose(
    name="corner", mTb=SE3(pin.utils.rotate("z", np.pi / 2), np.array([1.0, 0.5, 0.0]))
)


BENT = Posture(name="bent", q=READY + np.array([0.5, -0.3, 0.0, -0.3, 0.0, 0.2, 0.0]))


def standing(harness: Harness) -> tuple[float, float, float]:
    """x, y [m] and heading [degrees] of the base at rest."""
    harness.run_for(None, 1.0)
    oTb = harness.robot.read().oTb
    return (*oTb.translation[:2], degrees(atan2(oTb.rotation[1, 0], oTb.rotation[0, 0])))


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_drive_goes_to_a_base_pose_and_leaves_the_arm(robot):
    harness = Harness(robot=robot)
    assert success(harness, Drive("drive", harness.context, to=CORNER)) == "at corner"
    assert standing(harness) == pytest.approx((1.0, 0.5, 90.0), abs=6.0)
    np.testing.assert_allclose(harness.robot.read().oTb.translation[:2], [1.0, 0.5], atol=0.06)
    np.testing.assert_allclose(harness.robot.read().q, READY, atol=1e-9)


def test_drive_turns_and_goes_forward_from_where_it_stands():
    harness = Harness()
    leaf = Drive("drive", harness.context, turn_deg=-90.0, forward_m=0.6)
    assert harness.run(leaf) is Status.SUCCESS
    x, y, heading = standing(harness)
    assert (x, y) == pytest.approx((0.0, -0.6), abs=0.06)
    assert heading == pytest.approx(-90.0, abs=6.0)


def test_drive_goes_backwards_without_turning_round():
    harness = Harness()
    leaf, ahead = Drive("drive", harness.context, forward_m=-0.5), []
    while harness.run(leaf, seconds=0.01) is Status.RUNNING:
        ahead.append(harness.context.state.oTb.rotation[0, 0])
    assert min(ahead) > np.cos(np.radians(5.0))
    assert standing(harness)[0] == pytest.approx(-0.5, abs=0.06)


def test_driving_the_same_way_twice_goes_twice_as_far():
    """What the controller said of the end of the first way is not taken for the second."""
    harness = Harness()
    leaf = Drive("drive", harness.context, forward_m=0.4)
    assert harness.run(leaf) is Status.SUCCESS
    assert harness.run(leaf) is Status.SUCCESS
    assert standing(harness)[0] == pytest.approx(0.8, abs=0.12)


def test_drive_fails_on_a_fault_when_stuck_and_when_time_is_over():
    harness = Harness()
    leaf = Drive("drive", harness.context, to=CORNER, timeout_s=0.5)
    assert failure(harness, leaf).startswith("not at corner after 0.5 s: ")
    leaf = Drive("drive", harness.context, forward_m=1.0)
    harness.robot.stuck = True
    assert failure(harness, leaf, seconds=4.0).startswith("stuck on the way to the end of 1 m: ")
    harness.robot.faults = (REFLEX,)
    assert failure(harness, leaf) == "the arm hit something"


def test_move_arm_brings_every_joint_there_and_holds_the_base():
    harness = Harness()
    leaf = MoveArm("move_arm", harness.context, to=BENT)
    harness.tick(leaf)
    assert leaf.feedback_message == "setting out for bent"
    harness.tick(leaf)
    assert leaf.feedback_message == "29° to go"
    assert harness.run(leaf) is Status.SUCCESS
    np.testing.assert_allclose(harness.robot.read().q, BENT.q, atol=0.02)
    assert standing(harness) == (0.0, 0.0, 0.0)


def test_the_base_passes_the_poses_of_a_path_on_the_move_no_faster_than_it_may():
    harness, speeds = Harness(), []
    for x, y in ((1.0, 0.0), (2.0, 0.4), (3.0, 0.4)):
        to = BasePose(name="next", mTb=SE3(np.eye(3), np.array([x, y, 0.0])))
        leaf = Navigate("navigate", harness.context, to=to, speed_m_s=0.4, within_m=0.25)
        while leaf.status in (Status.INVALID, Status.RUNNING):
            harness.tick(leaf)
            speeds.append(float(harness.context.state.base_twist[0]))
        assert leaf.status is Status.SUCCESS, leaf.feedback_message
        assert speeds[-1] > 0.2
    assert max(speeds) < 0.41
