"""The behaviours that look: grasp and region_empty, with the real network on rendered frames."""

import numpy as np
import pytest
from pinocchio import SE3
from py_trees.common import Status
from stage import REFLEX, TABLE_TOP, Stage, block, looking_down, table_world

from behaviours import Region, ToolPose
from behaviours.grasp import Grasp
from behaviours.navigate import Navigate
from behaviours.region_empty import RegionEmpty
from hw.sim import Box, Placed, SimObject

REGION = Region(
    name="spot",
    wTr=SE3(np.eye(3), np.array([0.75, 0.0, TABLE_TOP + 0.1])),
    size=np.array([0.4, 0.4, 0.2]),
)


def looking_stage(*objects: SimObject) -> Stage:
    """The hand 0.35 m above the table, looking at the region."""
    stage = Stage(table_world(*objects))
    pose = ToolPose(name="above", wTe=looking_down(0.68, 0.0, TABLE_TOP + 0.35))
    assert stage.run(Navigate("navigate", stage.context, to=pose)) is Status.SUCCESS
    return stage


def grasp(stage: Stage, **options) -> Grasp:
    return Grasp("grasp", stage.context, within=REGION, **options)


@pytest.mark.parametrize(("x", "y"), [(0.75, 0.0), (0.70, 0.06), (0.80, -0.05)])
def test_grasp_finds_follows_and_holds_a_block(x, y):
    stage = looking_stage(block(x=x, y=y))
    leaf = grasp(stage)
    assert stage.run(leaf) is Status.SUCCESS
    assert stage.world.held is stage.world.find("block")
    assert stage.context.log.attempts == 1
    assert 0.005 < stage.context.log.grip_height < 0.05
    assert leaf.feedback_message.startswith("closed at ")


def test_the_goal_follows_an_object_that_is_moved_until_it_is_locked():
    stage = looking_stage(block(x=0.75, y=0.0))
    leaf = grasp(stage)
    stage.run_for(leaf, 0.3)
    assert not stage.context.eyes.tracker.locked
    stage.world.find("block").pose.translation = np.array([0.77, 0.02, TABLE_TOP + 0.025])
    assert stage.run(leaf) is Status.SUCCESS
    assert stage.world.held is stage.world.find("block")


def test_once_locked_the_goal_stays():
    stage = looking_stage(block())
    leaf = grasp(stage)
    while not stage.context.eyes.tracker.locked:
        stage.tick(leaf)
        assert leaf.status is Status.RUNNING
    locked = stage.context.eyes.grasp.wTg.copy()
    stage.world.find("block").pose.translation = np.array([0.60, 0.1, TABLE_TOP + 0.025])
    stage.run(leaf)
    assert stage.context.log.last_grasp.isApprox(locked, 1e-9)
    assert stage.world.held is None


def test_a_grasp_out_of_the_region_is_not_taken():
    stage = looking_stage(block(x=0.66, y=0.0))
    elsewhere = Region(
        name="elsewhere",
        wTr=SE3(np.eye(3), np.array([0.85, 0.0, TABLE_TOP + 0.1])),
        size=np.array([0.15, 0.2, 0.2]),
    )
    leaf = Grasp("grasp", stage.context, within=elsewhere)
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message.startswith("no grasp for 1.5 s: ")
    assert stage.context.log.attempts == 0


def test_an_empty_table_offers_no_grasp():
    stage = looking_stage()
    leaf = grasp(stage)
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message.startswith("no grasp for 1.5 s: ")
    assert len(leaf.feedback_message) > len("no grasp for 1.5 s: ")


def test_without_frames_there_is_no_grasp_and_no_motion():
    stage = looking_stage(block())
    stage.run_for(None, 1.0)
    stage.robot.blind = True
    before = stage.context.wTe.translation.copy()
    leaf = grasp(stage)
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message == "no grasp for 1.5 s: no camera frame"
    np.testing.assert_allclose(stage.context.wTe.translation, before, atol=1e-3)


def test_a_camera_that_goes_blind_on_the_way_ends_the_grasp():
    stage = looking_stage(block())
    leaf = grasp(stage)
    stage.run_for(leaf, 0.2)
    assert stage.context.eyes.grasp is not None
    stage.robot.blind = True
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message == "no grasp for 1.5 s: no camera frame"
    assert stage.context.log.attempts == 0


def test_a_fault_ends_the_grasp_and_the_grasp_is_remembered():
    stage = looking_stage(block())
    leaf = grasp(stage)
    stage.run_for(leaf, 0.5)
    stage.robot.faults = (REFLEX,)
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message == "the arm hit something"


def test_a_hand_that_does_not_move_gives_up():
    stage = looking_stage(block())
    stage.robot.stuck = True
    leaf = grasp(stage)
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message.startswith("cannot get above the grasp")


def test_fingers_that_never_stop_end_the_grasp():
    stage = looking_stage(block())
    stage.robot.restless = True
    leaf = grasp(stage)
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message == "the fingers still move after 3 s"


@pytest.mark.parametrize("after", [0.0, 0.3, 1.2, 2.0])
def test_a_grasp_may_be_halted_at_any_tick(after):
    stage = looking_stage(block())
    leaf = grasp(stage)
    stage.run_for(leaf, after + 0.01)
    leaf.stop(Status.INVALID)
    stage.run_for(None, 1.0)
    assert stage.speed < 1e-3
    assert stage.context.eyes.grasp is None


# region_empty


def test_an_empty_region_is_seen_to_be_empty():
    stage = looking_stage()
    leaf = RegionEmpty("region_empty", stage.context, region=REGION)
    assert stage.run(leaf) is Status.SUCCESS
    assert leaf.feedback_message == "nothing left to grasp"
    assert stage.clock.now() > 0.2


def test_a_region_with_something_in_it_is_not_empty():
    stage = looking_stage(block())
    leaf = RegionEmpty("region_empty", stage.context, region=REGION)
    assert stage.run(leaf) is Status.FAILURE
    area = float(leaf.feedback_message.split()[0])
    assert area == pytest.approx(24.0, abs=6.0)  # 4 cm x 6 cm, and what noise adds


def test_a_small_flat_thing_is_seen():
    flat = SimObject(
        name="flat",
        parts=(Placed(Box((0.01, 0.03, 0.0075)), SE3.Identity(), "flat"),),
        mass=0.05,
        pose=SE3(np.eye(3), np.array([0.75, 0.05, TABLE_TOP + 0.0075])),
    )
    stage = looking_stage(flat)
    leaf = RegionEmpty("region_empty", stage.context, region=REGION)
    assert stage.run(leaf) is Status.FAILURE


def test_a_blind_camera_does_not_make_a_region_empty():
    stage = looking_stage()
    stage.robot.blind = True
    leaf = RegionEmpty("region_empty", stage.context, region=REGION)
    assert stage.run(leaf) is Status.FAILURE
    assert leaf.feedback_message == "no camera frame"
