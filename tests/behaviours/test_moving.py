"""The behaviours that only move: recover, navigate, wait."""

from dataclasses import replace

import numpy as np
import pytest
from ended import failure, success
from harness import BUTTON, REFLEX, Harness, looking_down, table_world
from pinocchio import SE3
from py_trees.common import Status

from behaviours import Posture, ToolPose
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
    leaf = navigate(harness, POSE)
    assert success(harness, leaf) == "at over_there"
    error = harness.context.wTe.translation - POSE.wTe.translation
    assert np.linalg.norm(error) < 0.015


def test_navigate_ends_on_the_move_where_near_is_near_enough():
    exact, near = Harness(), Harness()
    assert exact.run(navigate(exact, POSE)) is Status.SUCCESS
    leaf = Navigate("navigate", near.context, to=POSE, within_m=0.1)
    assert near.run(leaf) is Status.SUCCESS
    left = np.linalg.norm(near.context.wTe.translation - POSE.wTe.translation)
    assert 0.03 < left < 0.1
    assert near.clock.now() < exact.clock.now() - 0.1


def test_navigate_stops_on_a_fault_and_says_which():
    harness = Harness(table_world())
    leaf = navigate(harness, POSE)
    harness.run_for(leaf, 1.0)
    harness.robot.faults = (REFLEX,)
    harness.tick(leaf)
    assert leaf.status is Status.FAILURE
    assert leaf.feedback_message == "the arm hit something"
    harness.run_for(None, 1.5)
    assert harness.speed < 1e-3


def test_a_leaf_may_be_halted_at_any_tick_and_the_robot_comes_to_rest():
    harness = Harness(table_world())
    leaf = navigate(harness, POSE)
    harness.run_for(leaf, 1.0)
    leaf.stop(Status.INVALID)
    harness.run_for(None, 1.5)
    assert harness.speed < 1e-3
    assert harness.run(leaf) is Status.SUCCESS  # and it can be started again


def test_recover_clears_a_reflex_rises_and_folds_the_arm():
    harness = Harness(table_world())
    harness.robot.faults = (REFLEX,)
    before = harness.context.wTe.translation[2]
    leaf = Recover("recover", harness.context, arm=FOLDED)
    harness.run_for(leaf, 1.3)
    assert harness.context.wTe.translation[2] > before + 0.05
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
        assert harness.robot.read().wTb.translation[0] < -0.2
    else:
        assert outcome is Status.FAILURE
        assert "before to the left" in leaf.feedback_message
    assert harness.robot.read().faults == ()
