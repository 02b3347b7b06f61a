"""Only what is seen standing at its place is placed, and a task counts what it has placed."""

import numpy as np
import pytest
from ended import failure
from harness import FAR, SPOT, Harness, block, held_block, over_the_table, place
from pinocchio import SE3
from py_trees.common import Status

from behaviours import Carried
from behaviours.conditions import AllPlaced
from behaviours.core.placed_object import Verdict
from behaviours.wait import Wait
from hw import TaskTime


def away(harness: Harness) -> None:
    """Somebody takes the block."""
    block = harness.world.find("block")
    harness.world.put("block", SE3(block.pose.rotation, np.array([-3.0, -3.0, 0.5])))


def sticks(harness: Harness) -> None:
    """The block comes along with the hand."""
    wTe = harness.context.wTe
    if "eTo" not in vars(harness):
        harness.eTo = wTe.actInv(harness.world.find("block").pose)
    harness.world.find("block").pose = wTe * harness.eTo


@pytest.mark.parametrize(("happens", "half_height"), [(away, 0.015), (sticks, 0.03)])
def test_what_does_not_stand_at_its_place_is_not_placed(happens, half_height):
    harness = held_block(block(half=(0.02, 0.03, half_height)))
    leaf = place(harness)
    harness.run_into(leaf, "rise")
    while leaf.status is Status.RUNNING:
        if happens is sticks or harness.world.find("block").pose.translation[0] > 0.0:
            happens(harness)
        harness.tick(leaf)
    assert leaf.status is Status.FAILURE
    assert leaf.feedback_message.startswith("let go, but ")
    assert harness.context.log.placed == 0


def test_a_task_is_done_only_when_all_that_was_seen_is_placed():
    log = (harness := over_the_table()).context.log
    leaf = AllPlaced("all_placed", harness.context, taken_from=FAR)
    assert harness.run(leaf) is Status.FAILURE  # nobody looked
    log.note_stock(FAR, 2)
    log.carried.append(Carried(begun=TaskTime(0.0), placed=TaskTime(1.0)))
    log.note_stock(FAR, 0)
    assert failure(harness, leaf) == "1 of 2 objects placed that were seen in table"
    log.carried.append(Carried(begun=TaskTime(1.0), placed=TaskTime(2.0)))
    assert harness.run(leaf) is Status.SUCCESS


@pytest.mark.parametrize("beside", [0.0, 0.6])
def test_of_two_that_touch_and_count_as_one_the_lost_one_is_missed(beside):
    """What falls back over its region is there to be placed; what falls elsewhere is not."""
    harness = held_block()
    log, grasped = harness.context.log, harness.context.wTe.copy()
    log.carried.clear()
    log.note_stock(SPOT, 1)
    log.attempt(TaskTime(0.0), TaskTime(1.0))
    log.last_grasp = grasped
    up = SE3(grasped.rotation, grasped.translation + np.array([0.0, beside, 0.2]))
    log.note_hand(up, grasped, None, TaskTime(2.0))
    log.note_hand(up, grasped, "the fingers closed on nothing", TaskTime(3.0))
    log.attempt(TaskTime(4.0), TaskTime(5.0))
    log.carried[-1].let_go = log.carried[-1].placed = TaskTime(6.0)
    leaf = AllPlaced("all_placed", harness.context, taken_from=SPOT)
    assert harness.run(leaf) is (Status.FAILURE if beside else Status.SUCCESS)
    lost = ", and 1 more left the hand, not seen to stand" if beside else ""
    text = f"1 of 1 objects placed that were seen in spot{lost}"
    assert leaf.feedback_message == text


def test_a_leaf_lets_the_log_notice_what_slips_out_on_the_way():
    harness = held_block()
    log = harness.context.log
    log.last_grasp = harness.context.wTe * SE3(np.eye(3), np.array([0.0, 0.2, 0.1]))
    leaf = Wait("wait", harness.context, duration_s=5.0)
    harness.tick(leaf)
    assert log.in_hand is not None
    harness.world.put("block", SE3(np.eye(3), np.array([-3.0, -3.0, 0.5])))
    harness.run_for(leaf, 1.5)
    assert log.in_hand is None
    assert log.messages[-1][1].startswith("what was held is gone: the fingers ")


def test_what_is_knocked_over_before_the_hand_is_up_is_not_placed():
    harness = held_block()
    leaf = place(harness)
    harness.run_into(leaf, "rise")
    released = harness.context.wTe.translation[2]
    while harness.context.wTe.translation[2] < released + 0.06:
        harness.tick(leaf)
    harness.context.placed_object.verdict = Verdict.STANDS  # as one frame before
    away(harness)
    assert failure(harness, leaf).startswith("let go, but nothing stands")
