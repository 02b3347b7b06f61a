"""What the behaviours take as evidence that the hand holds something, and that it let go."""

import re
from dataclasses import replace

import numpy as np
import pytest
from ended import failure, success
from harness import (
    BUTTON,
    FAR,
    ON_TABLE,
    REFLEX,
    TABLE_TOP,
    Harness,
    block,
    held_block,
    over_the_table,
    place,
    table_world,
    with_the_hand_at,
)
from pinocchio import SE3
from py_trees.common import Status

from behaviours import Region
from behaviours.conditions import HoldingObject
from behaviours.core.parameter_types import Posture
from behaviours.grasp import Grasp
from behaviours.places import Places
from behaviours.recover import Recover
from behaviours.retreat_check import RetreatCheck
from hw import TaskTime
from robots import load_robot, reach

READY = Posture(name="ready", q=load_robot("frankie").arm.ready)


def kill_gripper(harness: Harness, says_it_moves: bool = False) -> None:
    """From now on the fingers stay where they are, whatever they are told."""
    harness.robot.grip = lambda width, force: None
    harness.robot.restless = says_it_moves


def test_a_grasp_with_fingers_that_never_move_fails_and_the_grasp_is_not_blamed():
    harness = over_the_table(block(x=0.75))
    kill_gripper(harness)
    leaf = Grasp("grasp", harness.context, within=FAR)
    assert failure(harness, leaf) == "the fingers did not move"
    assert harness.context.log.attempts == 0
    assert harness.context.oTe.translation[2] > TABLE_TOP + 0.05 + 0.05  # it is off the block


@pytest.mark.parametrize(("width", "says_it_moves"), [(0.08, True), (0.04, False)])
def test_fingers_that_never_move_hold_nothing_wherever_they_stand(width, says_it_moves):
    harness = Harness(table_world())
    if width < 0.08:
        harness.robot.grip(width, 20.0)
        harness.run_for(None, 1.0)
    kill_gripper(harness, says_it_moves)
    harness.grip(0.0)
    for leaf in (
        RetreatCheck("retreat_check", harness.context),
        HoldingObject("holding_object", harness.context),
        place(harness),
    ):
        assert harness.run(leaf) is Status.FAILURE
        assert re.search("did not move|still move", leaf.feedback_message)
    assert harness.context.log.placed == 0


def test_something_nearly_as_wide_as_the_hand_is_held():
    thing = block(half=(0.0385, 0.03, 0.025), x=1.0)
    harness = with_the_hand_at(table_world(thing), 0.7, 0.0, TABLE_TOP + 0.03, np.pi / 2)
    harness.tick(None)
    thing.pose.translation = np.array([*harness.context.oTe.translation[:2], TABLE_TOP + 0.025])
    harness.grip(0.0)
    assert harness.context.state.gripper_width > 0.076
    leaf = RetreatCheck("retreat_check", harness.context)
    assert harness.run(leaf) is Status.SUCCESS, leaf.feedback_message


def test_an_object_that_is_lost_on_the_way_is_not_placed():
    harness = held_block()
    leaf = place(harness)
    harness.run_for(leaf, 0.2)
    read = harness.robot.read
    harness.robot.read = lambda: replace(read(), gripper_width=0.07)
    assert failure(harness, leaf) == "nothing left to place: the fingers have opened"


def test_what_is_let_go_is_placed_though_a_reflex_ends_the_placing():
    """From a wide object the fingers cannot open far."""
    harness = held_block(block(half=(0.02, 0.034, 0.03)))
    leaf = place(harness)
    harness.run_into(leaf, "release")
    harness.robot.faults = (REFLEX,)
    harness.tick(leaf)
    assert leaf.status is Status.FAILURE
    log = harness.context.log
    assert log.placed == 0, "the fingers have not opened yet"
    harness.robot.faults = ()
    harness.run_for(None, 1.0)
    assert log.in_hand is None
    assert log.placed == 0, "nobody has seen it standing"
    harness.run(Recover("recover", harness.context, arm=READY))
    assert log.placed == 1, "seen while the hand rises"
    assert log.places_used == {"table": {2}}
    assert len(harness.context.memory.set_down.shapes) == 1


def test_what_is_held_reaches_as_far_as_it_was_seen_to():
    harness = held_block()
    (bar,) = harness.context.memory.held
    assert reach(bar, np.array([1.0, 0.0, 0.0])) == pytest.approx(0.14)
    log = harness.context.log
    for farthest, reaches in ((0.09, 0.1), (0.3, 0.02)):  # more than the hand can hold: it touches
        log.grip_outline = np.array([(-0.03, 0.0, 0.0), (0.01, farthest, 0.0)])
        log.attempt(TaskTime(3.0), TaskTime(4.0))
        (box,) = harness.context.memory.held
        assert reach(box, np.array([0.0, 1.0, 0.0])) == pytest.approx(reaches, abs=0.003)


def test_what_may_be_long_is_set_down_off_what_stands_beside_its_place():
    harness = held_block()
    context = harness.context
    region = Region(name="table", mTr=ON_TABLE.oTr, size=np.array([0.6, 0.4, 0.2]))
    places, down = Places(context, region, 0.2), context.oTe.rotation
    here = places.centre(2)
    for away, off in ((0.2, 0.025), (0.3, 0.0)):
        context.memory.set_down.forget()
        context.memory.set_down.add(0.04, 0.03, SE3(down, here + away * down[:, 0]))
        np.testing.assert_allclose(places.beside(2, down, 0.09), -off * down[:, 0], atol=1e-3)
    context.memory.set_down.forget()
    long = np.array([(-0.15, -0.01, 0.0), (0.01, -0.01, 0.0), (0.01, 0.01, 0.0)])
    context.memory.set_down.add(0.04, 0.03, SE3(down, here + 0.25 * down[:, 0]), long)
    assert np.linalg.norm(places.beside(2, down, 0.09)) > 0.04  # sideways


def test_a_place_at_which_lowering_failed_is_not_tried_again():
    harness = held_block()
    leaf = place(harness)
    harness.run_into(leaf, "lower")
    harness.robot.faults = (BUTTON,)
    harness.tick(leaf)
    assert harness.context.log.places_blocked == {}  # an emergency stop says nothing of the place
    harness.robot.faults = ()
    harness.gate.acknowledge()
    harness.run_into(leaf, "lower")
    harness.robot.faults = (REFLEX,)
    harness.tick(leaf)
    assert harness.context.log.places_blocked == {"table": {2}}
    harness.robot.faults = ()
    assert success(harness, leaf) == "placed on table, place 4"


def test_places_that_are_taken_or_blocked_are_counted_and_unseen_ones_come_last():
    harness = Harness(table_world())
    log = harness.context.log
    places = Places(harness.context, FAR, 0.13)
    first = places.next_free()
    log.places_unseen["table"] = {first}
    assert places.next_free() != first
    every = set(range(1, len(places.slots) + 1))  # those between, too
    log.places_used["table"] = set(range(1, 7)) - {first}
    assert places.next_free() == first, "before those between the rows"
    log.places_used["table"], log.places_blocked["table"] = every - {3, 5, 6}, {3, 5, 6}
    told = failure(harness, place(harness), seconds=0.01)
    assert told == "no place free on table, 6 taken or blocked (3)"
