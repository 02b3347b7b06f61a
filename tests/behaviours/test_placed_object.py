"""Only what is seen standing at its place is placed, and a task counts what it has placed."""

import numpy as np
import pytest
from harness import FAR, Harness, block, held_block, over_the_table, place
from pinocchio import SE3
from py_trees.common import Status

from behaviours import Carried
from behaviours.conditions import AllPlaced
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


SLOW = pytest.mark.slow


@pytest.mark.parametrize(
    ("happens", "half_height"), [pytest.param(away, 0.015, marks=SLOW), (sticks, 0.03)]
)
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
    log.note_stock(FAR.name, 2)
    log.carried.append(Carried(begun=TaskTime(0.0), placed=TaskTime(1.0)))
    log.note_stock(FAR.name, 0)
    assert harness.run(leaf) is Status.FAILURE
    assert leaf.feedback_message == "1 of 2 objects placed that were seen in table"
    log.carried.append(Carried(begun=TaskTime(1.0), placed=TaskTime(2.0)))
    assert harness.run(leaf) is Status.SUCCESS
