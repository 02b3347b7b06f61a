"""What becomes of a fault: a pause that grows, the way from what was hit, memory, then a person."""

import numpy as np
import pinocchio as pin
import pytest
from ended import failure
from harness import REFLEX, Harness, table_world
from pinocchio import SE3
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from behaviours import BasePose, Navigate, Recover
from controller import BaseGoal, PoseGoal
from hw import Fault, FaultKind
from hw.sim import World
from robots import Box, Geom, Plane

FLOOR = Geom(Plane(), SE3.Identity(), "floor")
PEDESTAL = Geom(Box((0.1, 0.1, 0.2)), SE3(np.eye(3), np.array([1.2, 0.0, 0.2])), "pedestal")
BEYOND = BasePose(name="beyond", mTb=SE3(np.eye(3), np.array([2.5, 0.0, 0.0])))


def clears_of(harness: Harness) -> list[float]:
    """When the robot is asked to recover from now on [s]."""
    times: list[float] = []
    recover = harness.robot.recover

    def noted() -> None:
        times.append(harness.clock.now())
        recover()

    harness.robot.recover = noted
    return times


def drive(harness: Harness, ahead: float, heading: float = 0.0) -> None:
    """The base turns, goes ahead [m, rad] and meets something."""
    way = SE3(pin.utils.rotate("z", heading), np.zeros(3))
    goal = BaseGoal(wTb=way * SE3(np.eye(3), np.array([ahead, 0.0, 0.0])), reverse=ahead < 0.0)

    class Drives(Behaviour):
        def update(self) -> Status:
            harness.context.goal = goal
            return Status.RUNNING

    drives = Drives("drives")
    for _ in range(1500):
        harness.tick(drives)
        if harness.context.state.faults:
            return
    raise AssertionError("nothing was hit")


def pursue(harness: Harness, goal: BaseGoal | PoseGoal, seconds: float) -> None:
    """Go after a goal without a leaf."""
    for _ in range(round(seconds * 100)):
        state = harness.robot.read()
        harness.context.read(state)
        command, _ = harness.controller.step(state, goal, harness.gate.applied)
        harness.gate.send(command, state, harness.clock.now())
        harness.clock.sleep_until(harness.clock.now() + 0.01)
    harness._ticks = round(harness.clock.now() * 100)


def unknown_pedestal(robot: str = "frankie") -> Harness:
    """Something stands in the way that is on no map."""
    harness = Harness(World([FLOOR, PEDESTAL], []), robot)
    harness.context.fixtures = (FLOOR,)
    return harness


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_a_base_that_has_hit_what_nobody_knew_goes_back_and_then_around_it(robot):
    harness = unknown_pedestal(robot)
    times = clears_of(harness)
    navigate = Navigate("navigate", harness.context, to=BEYOND)
    assert failure(harness, navigate) == "the base hit pedestal"
    hit_at, hit_when = harness.context.state.wTb.translation[0], harness.clock.now()
    assert harness.run(Recover("recover", harness.context)) is Status.SUCCESS
    assert harness.context.state.wTb.translation[0] < hit_at - 0.2
    assert times == [pytest.approx(hit_when + 0.5, abs=0.05)]
    assert harness.run(navigate) is Status.SUCCESS, navigate.feedback_message
    assert len(times) == 1
    assert len(harness.world.touches) == 1


@pytest.mark.parametrize(("ahead", "heading"), [(-1.5, 0.0), (1.5, 2.5)])
def test_the_base_goes_away_from_the_side_that_was_touched(ahead, heading):
    direction = pin.utils.rotate("z", heading) @ np.array([ahead, 0.0, 0.0])
    wall = Geom(Box((0.1, 1.0, 0.2)), SE3(pin.utils.rotate("z", heading), 0.8 * direction), "wall")
    harness = Harness(World([FLOOR, wall], []))
    harness.context.fixtures = (FLOOR,)
    drive(harness, ahead, heading)
    [fault] = harness.context.state.faults
    assert abs(fault.bearing) < 0.5 if ahead > 0.0 else abs(fault.bearing) > 2.6
    here = harness.context.state.wTb.translation
    assert harness.run(Recover("recover", harness.context)) is Status.SUCCESS
    gone = harness.context.state.wTb.translation - here
    assert gone @ direction / np.linalg.norm(direction) < -0.2


@pytest.mark.parametrize("ahead", [0.4, -0.4])
def test_where_the_side_is_not_told_the_base_goes_back_along_where_it_came_from(ahead):
    harness = Harness(World([FLOOR], []))
    goal = BaseGoal(wTb=SE3(np.eye(3), np.array([ahead, 0.0, 0.0])), reverse=ahead < 0.0)
    pursue(harness, goal, 3.0)
    before = harness.robot.read().wTb.translation[0]
    bumped = Fault(kind=FaultKind.BUMPER, text="bumped", clearable=True)
    recover = Recover("recover", harness.context)
    for _ in range(3):  # and so when it comes back on the way
        harness.robot.faults = (bumped,)
        while harness.robot.faults:
            harness.tick(recover)
        harness.run_for(recover, 0.7)
        after = harness.robot.read().wTb.translation[0]
        assert (before - after) * np.sign(ahead) > 0.05
        before = after
    harness.robot.faults = (bumped,)
    harness.tick(recover)
    assert harness.context.fault_memory.given_up == "came back 3 times: bumped"


def test_what_comes_back_is_cleared_three_times_with_growing_pauses_and_then_left_to_a_person():
    """However many leaves try: the count is not theirs."""
    harness = Harness(table_world())
    harness.robot.faults, harness.robot.incurable = (REFLEX,), True
    times = clears_of(harness)
    for _ in range(40):
        recover = Recover("recover", harness.context)
        harness.run(recover, seconds=0.4)
        recover.stop(Status.INVALID)
    assert np.diff([0.0, *times]) == pytest.approx([0.5, 2.0, 8.0], abs=0.05)
    memory = harness.context.fault_memory
    assert memory.given_up == "came back 3 times: the arm hit something"
    memory.acknowledge()
    harness.robot.incurable = False
    assert harness.run(Recover("recover", harness.context)) is Status.SUCCESS
    assert len(times) == 4


def test_faults_at_other_places_are_cleared_with_pauses_too():
    harness = Harness(World([FLOOR], []))
    times = clears_of(harness)
    for k in range(5):
        harness.robot.faults = (REFLEX,)
        assert harness.run(Recover("recover", harness.context)) is Status.SUCCESS
        there = BasePose(name="there", mTb=SE3(np.eye(3), np.array([0.0, 0.7 * (k + 1), 0.0])))
        assert harness.run(Navigate("navigate", harness.context, to=there)) is Status.SUCCESS
    assert not harness.context.fault_memory.given_up
    assert (np.diff(times) > [1.99, 7.99, 7.99, 7.99]).all()


def test_a_hand_goes_back_the_way_that_it_came_before_it_rises():
    harness = Harness(table_world())
    harness.run_for(None, 0.1)
    wTe = harness.context.wTe
    ahead = SE3(wTe.rotation, wTe.translation + np.array([0.0, 0.25, 0.0]))
    pursue(harness, PoseGoal(wTe=ahead, straight=True, speed=0.3), 3.0)
    harness.run_for(None, 0.3)
    hit = harness.context.wTe.translation
    harness.robot.faults = (REFLEX,)
    recover = Recover("recover", harness.context)
    lowest_back = np.inf
    for _ in range(1000):
        harness.tick(recover)
        here = harness.context.wTe.translation
        if here[2] < hit[2] + 0.02:
            lowest_back = min(lowest_back, here[1] - hit[1])
        if recover.status is not Status.RUNNING:
            break
    assert recover.status is Status.SUCCESS
    assert lowest_back < -0.03
    assert harness.context.wTe.translation[2] > hit[2] + 0.1
    [stands] = harness.context.fault_memory.hit
    np.testing.assert_allclose(stands.pose.translation, hit, atol=0.01)
    harness.robot.faults = ()
    harness.clock.sleep_until(harness.clock.now() + 61.0)
    harness.tick(None)
    assert harness.context.fault_memory.hit == ()


def test_a_base_that_has_driven_the_arm_into_something_goes_back_before_the_hand_rises():
    harness = Harness(World([FLOOR], []))
    pursue(harness, BaseGoal(wTb=SE3(np.eye(3), np.array([2.0, 0.0, 0.0]))), 1.5)
    harness.robot.faults = (REFLEX,)
    recover, hands = Recover("recover", harness.context), []
    memory, stands = harness.context.fault_memory, []
    while not hands or recover.phase != "rise":
        harness.tick(recover)
        hands.append(harness.context.wTe.translation)
        stands.append(len(memory.hit))
    assert hands[-1][0] < max(hand[0] for hand in hands) - 0.2
    assert (stands[0], stands[-1]) == (0, 1), "no obstacle in the hand itself"


def test_what_was_hit_is_forgotten_after_a_time_and_when_the_base_is_relocalised():
    harness = unknown_pedestal()
    drive(harness, 1.5)
    assert len(harness.context.surroundings.fixtures) == 2
    same = harness.context.surroundings.fixtures
    harness.tick(None)
    assert harness.context.surroundings.fixtures is same  # or the map would be made at every tick
    harness.context.fault_memory.relocalise()
    assert harness.context.surroundings.fixtures is harness.context.fixtures


def test_what_was_hit_and_set_down_stays_on_the_map_while_odometry_drifts():
    harness = unknown_pedestal()
    context = harness.context
    here, seen = context.localisation, []
    for drift in (0.2, 0.7):
        here.mTw = SE3(np.eye(3), np.array([drift, 0.0, 0.0]))
        here.mTb = here.mTw * context.state.wTb
        if not seen:
            drive(harness, 1.5)
            context.set_down.add(0.04, 0.03, context.to_map(context.wTe))
        seen.append((context.surroundings.fixtures[-1], context.surroundings.loose[0]))
    assert seen[1] == seen[0]
    hit, set_down = (one.pose.translation[0] for one in seen[0])
    assert set_down == pytest.approx(context.wTe.translation[0] + 0.2, abs=0.15)
    assert hit > context.state.wTb.translation[0] + 0.2
