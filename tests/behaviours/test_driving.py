"""The behaviours that drive the base alone, or move the arm alone."""

from math import atan2, degrees

import numpy as np
import pinocchio as pin
import pytest
from ended import failure, success
from harness import REFLEX, Harness
from pinocchio import SE3
from py_trees.common import Status

from behaviours import BasePose, Posture
from behaviours.drive import Drive
from behaviours.move_arm import MoveArm
from behaviours.navigate import Navigate
from robots import load_robot

READY = load_robot("frankie").arm.ready

CORNER = BasePose(
    name="corner", mTb=SE3(pin.utils.rotate("z", np.pi / 2), np.array([1.0, 0.5, 0.0]))
)
BENT = Posture(name="bent", q=READY + np.array([0.5, -0.3, 0.0, -0.3, 0.0, 0.2, 0.0]))


def standing(harness: Harness) -> tuple[float, float, float]:
    """x, y [m] and heading [degrees] of the base at rest."""
    harness.run_for(None, 1.0)
    wTb = harness.robot.read().wTb
    return (*wTb.translation[:2], degrees(atan2(wTb.rotation[1, 0], wTb.rotation[0, 0])))


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_drive_goes_to_a_base_pose_and_leaves_the_arm(robot):
    harness = Harness(robot=robot)
    leaf = Drive("drive", harness.context, to=CORNER)
    assert success(harness, leaf) == "at corner"
    assert standing(harness) == pytest.approx((1.0, 0.5, 90.0), abs=6.0)
    np.testing.assert_allclose(harness.robot.read().wTb.translation[:2], [1.0, 0.5], atol=0.06)
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
    leaf = Drive("drive", harness.context, forward_m=-0.5)
    headings = []
    while leaf.status is not Status.SUCCESS:
        harness.tick(leaf)
        headings.append(standing_heading(harness))
    assert max(map(abs, headings)) < 5.0
    assert standing(harness)[0] == pytest.approx(-0.5, abs=0.06)


def standing_heading(harness: Harness) -> float:
    rotation = harness.context.state.wTb.rotation
    return degrees(atan2(rotation[1, 0], rotation[0, 0]))


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
    assert failure(harness, leaf, seconds=8.0).startswith("stuck on the way to the end of 1 m: ")
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
