"""Motions that leaves share: progress, the time of a grasp, one goal a tick, way down."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from ended import failure
from harness import Harness, block, looking_down, over_the_table, table_world
from pinocchio import SE3
from py_trees.common import Status

from behaviours import BasePose, Leaf, LeafCrashedError, Progress, Region, ToolPose
from behaviours.core.motion import over_grasp
from behaviours.drive import Drive
from behaviours.grasp import Grasp
from behaviours.navigate import Navigate
from controller import BaseGoal, KinematicState

FAR_AWAY = ToolPose(name="far_away", mTe=looking_down(2.5, 0.5, 0.8))


def base_pose(x: float, y: float, degrees: float) -> BasePose:
    return BasePose(
        name="there", mTb=SE3(pin.utils.rotate("z", np.radians(degrees)), np.array([x, y, 0.0]))
    )


def test_a_base_that_swings_round_is_not_stuck():
    harness = Harness()
    start, home = base_pose(1.5, 1.0, 90.0), base_pose(0.0, 0.0, 0.0)
    assert harness.run(Drive("drive", harness.context, to=start)) is Status.SUCCESS
    leaf = Drive("drive", harness.context, to=home)
    assert harness.run(leaf) is Status.SUCCESS, leaf.feedback_message


def test_a_robot_that_only_moves_about_is_stuck_in_the_end():
    """It turns on the spot, whatever it is told."""
    harness = Harness()
    send = harness.robot.send
    turning = np.array([0.0, 0.0, 0.5])
    harness.robot.send = lambda command: send(replace(command, base_twist=turning, qd=np.zeros(7)))
    leaf = Navigate("navigate", harness.context, to=base_pose(2.0, 0.0, 0.0))
    assert failure(harness, leaf, seconds=40.0).startswith("stuck")
    assert harness.clock.now() < 25.0  # a turn brings the base's heading nearer once


def test_a_goal_out_of_reach_is_given_up():
    harness = Harness(table_world())
    leaf = Navigate(
        "navigate", harness.context, to=ToolPose(name="sky", mTe=looking_down(0.5, 0.0, 2.5))
    )
    assert failure(harness, leaf, seconds=60.0).startswith(
        "cannot get to sky: 2.50 m up: tilted like this"
    )
    assert harness.clock.now() < 0.5
    assert harness.robot.read().oTb.isApprox(SE3.Identity())


def test_a_pause_counts_in_no_patience():
    harness = Harness(table_world())
    leaf = Navigate("navigate", harness.context, to=FAR_AWAY)
    harness.run_for(leaf, 1.0)
    harness.robot.stuck = True
    harness.run_for(leaf, 2.0)
    harness.task_clock.hold()
    harness.run_for(None, 20.0)
    harness.task_clock.release()
    harness.robot.stuck = False
    harness.run_for(leaf, 0.1)
    assert leaf.status is Status.RUNNING
    assert harness.run(leaf) is Status.SUCCESS


def test_late_ticks_count_in_no_patience():
    harness = Harness(table_world())
    progress = Progress(harness.context)
    here = KinematicState(harness.context.state.oTb, harness.context.state.q)
    _, report = harness.controller.step(here, BaseGoal(target=FAR_AWAY.oTe), harness.gate.applied)
    assert not progress.is_stuck(report)
    harness.clock.sleep_until(60.0)
    assert not progress.is_stuck(report)


def test_a_hand_that_is_late_when_it_is_down_rises_before_it_fails():
    harness = over_the_table(block(x=0.75))
    region = Region(name="spot", mTr=SE3(np.eye(3), np.array([0.75, 0, 0.6])), size=np.full(3, 0.4))
    leaf = Grasp("grasp", harness.context, within=region)
    harness.run_into(leaf, "descend")
    leaf._timeout = 0.0
    before = harness.context.oTe.translation[2]
    harness.tick(leaf)
    assert leaf.phase == "rise"
    assert failure(harness, leaf) == "not done after 0 s"
    assert harness.context.oTe.translation[2] > before + 0.05


def test_two_leaves_that_move_the_robot_at_the_same_time_are_named():
    harness = Harness(table_world())
    first = Navigate("go there", harness.context, to=FAR_AWAY)
    second = Drive("drive", harness.context, forward_m=1.0)

    class Both(Leaf):
        def update(self) -> Status:
            first.tick_once()
            second.tick_once()
            return Status.RUNNING

    with pytest.raises(LeafCrashedError, match="`go there` and `drive` both move the robot"):
        harness.tick(Both("both", harness.context))


@pytest.mark.parametrize(
    ("aside", "above", "goes_to"), [(0.005, 0.08, 0.0), (0.028, 0.08, 0.08), (0.028, 0.01, 0.0)]
)
def test_a_hand_that_has_strayed_comes_back_at_its_height(aside, above, goes_to):
    harness = Harness()
    harness.reach_over(looking_down(0.65, 0.0, 0.6))
    harness.run_for(None, 0.01)
    hand = harness.context.oTe
    oTg = hand * SE3(np.eye(3), np.array([aside, 0.0, above]))
    went = oTg.actInv(over_grasp(oTg, harness.context).translation)
    np.testing.assert_allclose(went, [0.0, 0.0, -goes_to], atol=1e-9)
