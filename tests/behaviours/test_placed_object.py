"""Only what is seen standing at its place is placed, and a task counts what it has placed."""

from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest
from ended import failure
from harness import (
    FAR,
    SPOT,
    TABLE_TOP,
    Harness,
    block,
    held_block,
    over_the_table,
    place,
)
from pinocchio import SE3
from py_trees.common import Status

from behaviours import Carried, Now
from behaviours.conditions import AllPlaced
from behaviours.core.placed_object import PlacedObjectWatch, Verdict
from behaviours.grasp import Grasp
from behaviours.wait import Wait
from hw import DepthFrame, TaskTime
from hw.sim import DepthRenderer
from perception import Segment
from robots import Geom, Plane, load_robot


def away(harness: Harness) -> None:
    """Somebody takes the block."""
    block = harness.world.find("block")
    harness.world.put("block", SE3(block.pose.rotation, np.array([-3.0, -3.0, 0.5])))


def sticks(harness: Harness) -> None:
    """The block comes along with the hand."""
    oTe = harness.context.oTe
    if "eTo" not in vars(harness):
        harness.eTo = oTe.actInv(harness.world.find("block").pose)
    harness.world.find("block").pose = oTe * harness.eTo


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
    log.note_stock(FAR, [CUBE, CUBE])
    log.carried.append(Carried(begun=TaskTime(0.0), placed=TaskTime(1.0)))
    log.note_stock(FAR, [])
    assert failure(harness, leaf) == "1 of 2 objects placed that were seen in table"
    log.carried.append(Carried(begun=TaskTime(1.0), placed=TaskTime(2.0)))
    assert harness.run(leaf) is Status.SUCCESS


CUBE = Segment(np.array([0.7, 0.0, TABLE_TOP]), area=16e-4)


@pytest.mark.parametrize("beside", [0.0, 0.6])
def test_of_two_that_touch_and_count_as_one_the_lost_one_is_missed(beside):
    """What falls back over its region is there to be placed; what falls elsewhere is not."""
    harness = held_block()
    log, grasped = harness.context.log, harness.context.oTe.copy()
    log.carried.clear()
    log.note_stock(SPOT, [CUBE])
    log.attempt(TaskTime(0.0), TaskTime(1.0))
    log.last_grasp = grasped
    up = SE3(grasped.rotation, grasped.translation + np.array([0.0, beside, 0.2]))
    log.note_hand(up, grasped, None, TaskTime(2.0))
    log.note_hand(up, grasped, "the fingers closed on nothing", TaskTime(3.0))
    log.attempt(TaskTime(4.0), TaskTime(5.0))
    log.carried[-1].let_go = log.carried[-1].placed = TaskTime(6.0)
    leaf = AllPlaced("all_placed", harness.context, taken_from=SPOT)
    if not beside:
        leaf.tick_once()
        assert leaf.feedback_message == "not known: spot was not looked at since one fell back"
        log.note_stock(SPOT, [])
    assert harness.run(leaf) is (Status.FAILURE if beside else Status.SUCCESS)
    lost = ", and 1 more left the hand, not seen to stand" if beside else ""
    text = f"1 of 1 objects placed that were seen in spot{lost}"
    assert leaf.feedback_message == text


@pytest.mark.parametrize(
    ("before", "after", "is_known"),
    [(32e-4, 16e-4, False), (32e-4, 31e-4, True), (20e-4, 10e-4, True)],
)
def test_one_of_two_that_touched_is_missed_where_less_is_left_than_before(before, after, is_known):
    """A single object that fell back may lie on another side."""
    harness = held_block()
    log, grasped = harness.context.log, harness.context.oTe.copy()
    log.carried.clear()
    log.closing.rested = 0.04
    log.note_stock(SPOT, [CUBE._replace(area=before)])
    log.attempt(TaskTime(0.0), TaskTime(1.0))
    up = SE3(grasped.rotation, grasped.translation + np.array([0.0, 0.0, 0.2]))
    log.note_hand(up, grasped, None, TaskTime(2.0))
    log.note_hand(up, grasped, "the fingers closed on nothing", TaskTime(3.0))
    log.note_stock(SPOT, [CUBE._replace(area=after)])
    log.carried[-1].let_go = log.carried[-1].placed = TaskTime(6.0)
    log.note_stock(SPOT, [])
    leaf = AllPlaced("all_placed", harness.context, taken_from=SPOT)
    leaf.tick_once()
    assert leaf.status is (Status.SUCCESS if is_known else Status.RUNNING)


def test_a_grasp_counts_again_where_one_fell_back():
    harness = over_the_table(block())
    log = harness.context.log
    log.note_stock(SPOT, [CUBE, CUBE])
    log.stocks["spot"].fell = True
    harness.run_for(Grasp("grasp", harness.context, within=SPOT), 0.5)
    assert (log.stocks["spot"].fell, len(log.stocks["spot"].pieces)) == (False, 1)


def test_a_leaf_lets_the_log_notice_what_slips_out_on_the_way():
    harness = held_block()
    log = harness.context.log
    log.last_grasp = harness.context.oTe * SE3(np.eye(3), np.array([0.0, 0.2, 0.1]))
    leaf = Wait("wait", harness.context, duration_s=5.0)
    harness.tick(leaf)
    assert log.in_hand is not None
    harness.world.put("block", SE3(np.eye(3), np.array([-3.0, -3.0, 0.5])))
    harness.run_for(leaf, 1.5)
    assert log.in_hand is None
    assert log.messages[-1][1].startswith("what was held is gone: the fingers ")


class Rising:
    """A hand that rises from where it let go of something, and what its camera shows there."""

    def __init__(self, before: np.ndarray) -> None:
        self.state = SimpleNamespace(stamp=0.0, oTb=SE3.Identity())
        self.robot = SimpleNamespace(description=load_robot("frankie"))
        self.vision, self.memory, self.now, self.x = self, self, Now(state=self.state), 0.7
        self.clock = SimpleNamespace(now=lambda: TaskTime(self.state.stamp))
        self.timed = nullcontext
        self.blindness, self.oTe = lambda _: "", self._looking_down(0.0)
        self.carried, centre = Carried(begun=TaskTime(0.0)), np.array([self.x, 0.0, TABLE_TOP])
        self.watch = PlacedObjectWatch(self, self.carried, centre, 0.06, before)
        self.placed_object = self.watch

    def _looking_down(self, up: float) -> SE3:
        return SE3(np.diag([1.0, -1.0, -1.0]), np.array([self.x, 0.0, TABLE_TOP + 0.3 + up]))

    def sees(self, up: float, height: float) -> Verdict:
        """What is said of a new picture, from so high, of something as high as that."""
        self.oTe = self._looking_down(up)
        self.state.stamp = now = self.state.stamp + 0.1
        camera = self.robot.description.camera
        oTc, intrinsics = self.oTe * camera.eTc, camera.intrinsics
        top = Geom(Plane(), SE3(np.eye(3), np.array([0.0, 0.0, TABLE_TOP + height])))
        depth = DepthRenderer(intrinsics).render([top], oTc)
        frame = DepthFrame(depth=depth, intrinsics=intrinsics, oTc=oTc, stamp=now)
        self.newest = lambda _: frame
        self.watch.look(self)
        return self.watch.verdict


def seen_before(points: int, elsewhere: float) -> np.ndarray:
    """Of 400 points, so many are known to be bare."""
    return np.where(np.arange(400) < points, 0.0, elsewhere)


BARE = seen_before(400, 0.0)
UNSEEN, STANDS, GONE = Verdict
PICTURES = [  # from such heights, of such heights
    (BARE, (0.06, 0.09, 0.12), (0.0035, 0.0035, 0.0035), GONE),
    (BARE, (0.06, 0.09, 0.12), (0.0045, 0.0045, 0.0045), STANDS),
    (BARE, (0.1, 0.124), (0.02, 0.02), UNSEEN),  # hardly from another height
    (BARE, (0.126, 0.1), (0.02, 0.02), STANDS),
    (BARE, (0.1, 0.2), (0.02, 0.049), STANDS),
    (BARE, (0.1, 0.2), (0.02, 0.051), UNSEEN),  # it comes along
    (BARE, (0.1, 0.2, 0.2, 0.2, 0.2), (0.02, 0.02, 0.0, 0.0, 0.0), GONE),  # knocked over then
    (BARE, (0.1, 0.1), (0.0, 0.0), UNSEEN),
    (BARE, (0.1, 0.1, 0.1), (0.0, 0.0, 0.0), GONE),
    (BARE, (0.1, 0.1, 0.1, 0.1), (0.0, 0.0, 0.02, 0.0), UNSEEN),  # not in a row
    (BARE, (0.049, 0.049, 0.049), (0.0, 0.0, 0.0), UNSEEN),  # the hand may hide it
    (BARE, (0.051, 0.051, 0.051), (0.0, 0.0, 0.0), GONE),
    (seen_before(299, np.nan), (0.1, 0.1, 0.1), (0.0, 0.0, 0.0), UNSEEN),
    (seen_before(301, np.nan), (0.1, 0.1, 0.1), (0.0, 0.0, 0.0), GONE),
    (seen_before(0, 0.01), (0.1, 0.1, 0.1), (0.01, 0.01, 0.01), GONE),  # it was so high before
    (seen_before(7, 1.0), (0.1, 0.2), (0.02, 0.02), UNSEEN),  # too small
    (seen_before(9, 1.0), (0.1, 0.2), (0.02, 0.02), STANDS),
]


@pytest.mark.parametrize(("before", "ups", "heights", "verdict"), PICTURES)
def test_what_the_pictures_from_a_rising_hand_tell(before, ups, heights, verdict):
    hand = Rising(before)
    assert [hand.sees(*one) for one in zip(ups, heights, strict=True)][-1] is verdict
    assert (hand.carried.placed is not None) is (verdict is STANDS)


def test_only_a_new_picture_tells_something():
    hand = Rising(BARE)
    hand.sees(0.1, 0.0)
    hand.watch.look(hand)
    hand.newest = lambda _: None
    hand.watch.look(hand)
    hand.blindness = lambda _: "no camera frame"
    assert hand.sees(0.1, 0.0) is UNSEEN
    assert hand.watch.empty == 1


def test_a_hand_that_has_left_looks_no_more_once_it_knows_though_the_robot_is_relocalised():
    hand = Rising(BARE)
    hand.sees(0.31, 0.02)
    hand.now.relocalised, hand.state.oTb = "by 2 m", SE3(np.eye(3), np.array([2.0, 0.0, 0.0]))
    hand.x += 2.0
    hand.sees(0.27, 0.02)
    hand.now.relocalised = ""
    assert hand.sees(0.28, 0.02) is STANDS
    assert hand.sees(0.29, 0.02) is STANDS
    assert (hand.placed_object, hand.watch.shown) == (hand.watch, hand.state.stamp)
    hand.sees(0.31, 0.02)
    assert hand.placed_object is None
