"""The behaviours that handle an object: the fingers, retreat_check, place."""

import re
from dataclasses import replace

import numpy as np
import pytest
from ended import failure
from harness import (
    FAR,
    ON_TABLE,
    REFLEX,
    TABLE_TOP,
    Harness,
    block,
    held_block,
    looking_down,
    place,
    table_world,
)
from pinocchio import SE3
from py_trees.common import Status

from behaviours import Place, Region, ToolPose
from behaviours.conditions import HoldingObject
from behaviours.hand_over import HandOver, Receive
from behaviours.open_gripper import OpenGripper
from behaviours.places import Places, slots
from behaviours.retreat_check import RetreatCheck
from hw.sim.contact import separation
from robots import reach
from trees.words.modifiers import While

OUT = ToolPose(name="out", mTe=looking_down(0.8, 0.0, TABLE_TOP + 0.3))


def with_the_fingers_at_20_mm() -> tuple[Harness, OpenGripper]:
    harness = Harness(table_world())
    harness.grip(0.02)
    return harness, OpenGripper("open_gripper", harness.context)


def test_open_gripper_opens_and_waits():
    harness, leaf = with_the_fingers_at_20_mm()
    assert harness.run(leaf) is Status.SUCCESS
    assert harness.robot.read().gripper_width >= 0.076
    harness.tick(leaf)
    assert leaf.status is Status.SUCCESS  # open already: done in one tick


def test_open_gripper_fails_on_a_fault_and_on_fingers_that_stop_or_do_not_move():
    harness, leaf = with_the_fingers_at_20_mm()
    harness.robot.faults = (REFLEX,)
    assert harness.run(leaf) is Status.FAILURE
    harness.robot.faults = ()
    harness.tick(leaf)
    harness.robot.grip(0.03, 20.0)  # somebody else stops the fingers half way
    assert failure(harness, leaf) == "the fingers stopped at 30 mm"
    harness.robot.grip = lambda width, force: None
    assert failure(harness, leaf) == "the fingers did not move"


def test_retreat_check_lifts_what_is_held():
    harness = held_block()
    holding = HoldingObject("holding_object", harness.context)
    harness.tick(holding)
    assert holding.status is Status.SUCCESS
    leaf = RetreatCheck("retreat_check", harness.context)
    assert harness.run(leaf) is Status.SUCCESS
    assert re.fullmatch("holding something 4[01] mm wide", leaf.feedback_message)
    assert harness.world.find("block").pose.translation[2] > TABLE_TOP + 0.17


@pytest.fixture(scope="module")
def placed():
    """The harness after an object was set down, and the leaf that did it."""
    harness = held_block()
    harness.run(RetreatCheck("retreat_check", harness.context))
    leaf = place(harness)
    assert harness.run(leaf) is Status.SUCCESS
    return harness, leaf


def test_place_sets_the_object_down_where_it_is_free(placed):
    harness, leaf = placed
    assert leaf.feedback_message == "placed on table, place 2"  # 1 is in the row before it
    thing = harness.world.find("block")
    assert harness.world.resting_on(thing) == "table"
    np.testing.assert_allclose(thing.pose.translation[:2], slots(FAR, 0.13)[1][:2], atol=0.02)
    assert harness.context.log.placed == 1
    assert harness.world.held is None


def test_the_arm_keeps_off_what_it_has_set_down_until_it_grasps_it_again(placed):
    harness, _ = placed
    (known,) = harness.context.surroundings.loose
    (thing,) = harness.world.find("block").placed()
    away, _ = separation(known, thing)
    assert away < -0.02  # it is where the robot takes it to be
    height = reach(known, np.array([0.0, 0.0, 1.0])) - TABLE_TOP
    assert 0.03 < height < 0.08
    harness.context.memory.set_down.grasp(known.pose.translation + np.array([0.0, 0.3, 0.0]))
    assert harness.context.surroundings.loose == (known,)
    harness.context.memory.set_down.grasp(known.pose.translation)
    assert harness.context.surroundings.loose == ()


def test_when_the_rows_are_full_places_between_them_are_used():
    """A bin of the usual size has room for more than its one row."""
    context = Harness().context
    region = Region(name="bin", mTr=ON_TABLE.oTr, size=np.array([0.5, 0.36, 0.2]))
    places = Places(context, region, 0.2)
    used = context.log.places_used.setdefault("bin", set())
    found = []
    while (number := places.next_free()) is not None:
        used.add(number)
        found.append(places.slots[number - 1])
    assert len(found) >= 6
    apart = np.linalg.norm(np.array(found)[:, None] - np.array(found), axis=2)
    assert apart[apart > 0].min() >= 0.5 * 0.2
    assert region.contains(np.array(found) + np.array([0.0, 0.0, 1e-6])).all()
    assert places.none_free() == "no place free on bin, 2 taken"


def test_place_fails_on_a_fault_and_when_it_cannot_get_there():
    harness = held_block()
    leaf = place(harness)
    harness.run_for(leaf, 0.1)
    harness.robot.faults = (REFLEX,)
    assert harness.run(leaf) is Status.FAILURE
    harness.robot.faults, harness.robot.stuck = (), True
    assert failure(harness, leaf).startswith("over the place: stuck 0.")


HERE = ToolPose(name="here", mTe=looking_down(0.9, 0.1, TABLE_TOP))


def test_exactly_there_means_nowhere_else():
    """On a pose where something stands nothing is set down, nor on what is not there."""
    harness = held_block()
    harness.world.objects.append(block(x=0.9, y=0.1, name="other"))
    assert failure(harness, Place("place", harness.context, at=HERE)) == "here is taken"
    harness.world.objects.pop()
    leaf = Place("place", harness.context, onto=FAR)
    assert failure(harness, leaf).startswith("nothing is seen to stack it on: 8 % of table")
    assert harness.world.held is not None


def pulls(harness: Harness) -> None:
    """A person turns the block between the fingers, and has it once they open."""
    robot, grip = harness.robot, harness.robot.grip

    def opens(width: float, force: float) -> None:
        del robot.read, robot.grip
        harness.world.put("block", SE3(np.eye(3), np.array([-8.0, -8.0, 0.5])))
        grip(width, force)

    reads(harness, lambda width, stamp: width + 0.003)
    robot.grip = opens


def test_a_person_takes_what_is_held_out_and_gives_another_thing():
    harness = held_block()
    leaf = HandOver("hand_over", harness.context, at=OUT, timeout_s=2.0)
    assert failure(harness, leaf) == "nobody took it within 2 s"
    assert harness.world.held is not None
    harness.run_into(leaf, "offer")
    pulls(harness)
    assert harness.run(leaf) is Status.SUCCESS
    assert leaf.gripper_is_open
    assert harness.context.log.in_hand is None

    receive = Receive("receive", harness.context, at=OUT, every_s=0.5, timeout_s=3.0)
    assert failure(harness, receive) == "nothing was given within 3 s"
    harness.run_into(receive, "fingers")
    harness.run_into(receive, "offer")
    gift = replace(block(name="gift"), pose=SE3(np.eye(3), harness.context.oTe.translation))
    harness.world.objects.append(gift)
    assert harness.run(receive) is Status.SUCCESS
    assert receive.feedback_message in ("given something 40 mm wide", "given something 60 mm wide")
    assert harness.context.log.in_hand is not None


def reads(harness: Harness, change) -> None:
    """From now on the width of the fingers reads `change(width, stamp)`."""
    read = harness.robot.read
    harness.robot.read = lambda: replace(
        state := read(), gripper_width=change(state.gripper_width, state.stamp)
    )


@pytest.mark.parametrize("disturbed", ["noise", "bump"])
def test_noise_and_a_bump_take_nothing_out_of_the_hand(disturbed):
    harness = held_block()
    leaf = HandOver("hand_over", harness.context, at=OUT, timeout_s=4.0)
    harness.run_into(leaf, "offer")
    rng, begun = np.random.default_rng(1), harness.clock.now()
    change = {
        "noise": lambda width, stamp: width + rng.normal(0.0, 3e-4),
        "bump": lambda width, stamp: width + 1.2e-3 * (1.0 <= stamp - begun < 1.05),
    }
    reads(harness, change[disturbed])
    assert failure(harness, leaf) == "nobody took it within 4 s"
    assert harness.world.held is not None


def test_what_slips_out_while_it_is_held_out_was_not_handed_over():
    harness = held_block()
    leaf = HandOver("hand_over", harness.context, at=OUT)
    harness.run_into(leaf, "offer")
    harness.run_for(leaf, 0.5)
    harness.world.put("block", harness.world.find("block").pose)
    assert failure(harness, leaf).startswith("it left the fingers before they opened")


@pytest.mark.parametrize("disturbed", ["dirt", "offset", "halfway", "finger"])
def test_nobody_gives_what_only_the_fingers_feel(disturbed):
    harness = Harness(table_world())
    leaf = Receive("receive", harness.context, at=OUT, every_s=0.5, timeout_s=3.0)
    if disturbed == "dirt":
        reads(harness, lambda width, stamp: max(width, 0.012))
    elif disturbed == "offset":
        reads(harness, lambda width, stamp: width + 0.002)
    harness.run_into(leaf, "offer")
    if disturbed == "halfway":
        grip, here = harness.robot.grip, harness.context
        harness.robot.grip = lambda to, force: grip((to + here.state.gripper_width) / 2.0, force)
    elif disturbed == "finger":
        finger = replace(block((0.0085,) * 3, name="f"), pose=harness.context.oTe)
        harness.world.objects.append(finger)
        harness.run_into(leaf, "fingers")
        while harness.world.held is None:
            harness.tick(leaf)
        harness.run_for(leaf, 0.4)
        harness.world.put("f", SE3(np.eye(3), np.array([-2.0, 0.0, 0.1])))
    assert harness.run(leaf) is Status.FAILURE
    ends = r"nothing was given within 3 s|the fingers stopped at [45]\d mm"
    assert re.fullmatch(ends, leaf.feedback_message)
    assert harness.context.log.in_hand is None


def test_a_retreat_holds_nothing_at_a_width_at_which_the_fingers_did_not_close():
    """As from the gable of a carton: 10 mm, then less and less."""
    harness = held_block(block(half=(0.005, 0.02, 0.025)))
    harness.run_for(None, 0.3)
    leaf = RetreatCheck("retreat_check", harness.context)
    harness.run_for(leaf, 0.1)
    begun = harness.clock.now()
    reads(harness, lambda width, stamp: max(0.002, width - 0.02 * (stamp - begun)))
    assert failure(harness, leaf) == "the fingers have slipped off, from 10 mm"


def test_a_guard_against_loss_lets_the_object_be_set_down():
    harness = held_block()
    context = harness.context
    holds = HoldingObject("holding_object", context)
    guarded = While(place(harness), holds, context.clock.now)
    assert harness.run(guarded) is Status.SUCCESS, guarded.feedback_message
    assert context.log.placed == 1
    assert harness.run(HoldingObject("holding_object", context)) is Status.FAILURE
