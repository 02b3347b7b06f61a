"""What becomes of a fault: a pause that grows, the way from what was hit, memory, then a person."""

import numpy as np
import pinocchio as pin
import pytest
from ended import failure
from harness import REFLEX, Harness, table_world
from pinocchio import SE3
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from scripted import Script, up

from behaviours import BasePose, Intent, Navigate, Recover
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
    goal = BaseGoal(target=way * SE3(np.eye(3), np.array([ahead, 0.0, 0.0])), reverse=ahead < 0.0)

    class Drives(Behaviour):
        def update(self) -> Status:
            harness.context.now.intend(Intent(goal, self))
            return Status.RUNNING

    drives = Drives("drives")
    while not harness.context.state.faults:
        assert harness.clock.now() < 15.0, "nothing was hit"
        harness.tick(drives)


def pursue(harness: Harness, goal: BaseGoal | PoseGoal, seconds: float) -> None:
    """Go after a goal without a leaf."""
    for _ in range(round(seconds * 100)):
        harness.pursue(goal)


def unknown_pedestal(robot: str = "frankie") -> Harness:
    """Something stands in the way that is on no map."""
    harness = Harness(World([FLOOR, PEDESTAL], []), robot)
    harness.context.around.fixtures = (FLOOR,)
    return harness


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_a_base_that_has_hit_what_nobody_knew_goes_back_and_then_around_it(robot):
    harness = unknown_pedestal(robot)
    times = clears_of(harness)
    navigate = Navigate("navigate", harness.context, to=BEYOND)
    assert failure(harness, navigate) == "the base hit pedestal"
    hit_at, hit_when = harness.context.state.oTb.translation[0], harness.clock.now()
    assert harness.run(Recover("recover", harness.context)) is Status.SUCCESS
    assert harness.context.state.oTb.translation[0] < hit_at - 0.2
    assert times == [pytest.approx(hit_when + 0.5, abs=0.05)]
    assert harness.run(navigate) is Status.SUCCESS, navigate.feedback_message
    assert len(times) == 1
    assert len(harness.world.touches) == 1


@pytest.mark.parametrize(("ahead", "heading"), [(-1.5, 0.0), (1.5, 2.5)])
def test_the_base_goes_away_from_the_side_that_was_touched(ahead, heading):
    direction = pin.utils.rotate("z", heading) @ np.array([ahead, 0.0, 0.0])
    wall = Geom(Box((0.1, 1.0, 0.2)), SE3(pin.utils.rotate("z", heading), 0.8 * direction), "wall")
    harness = Harness(World([FLOOR, wall], []))
    harness.context.around.fixtures = (FLOOR,)
    drive(harness, ahead, heading)
    [fault] = harness.context.state.faults
    assert abs(fault.bearing) < 0.5 if ahead > 0.0 else abs(fault.bearing) > 2.6
    here, fastest = harness.context.state.oTb.translation, 0.0
    recover = Recover("recover", harness.context)
    while harness.run(recover, seconds=0.01) is Status.RUNNING:
        fastest = max(fastest, abs(harness.context.state.base_twist[0]))
    assert recover.status is Status.SUCCESS
    gone = harness.context.state.oTb.translation - here
    assert gone @ direction / np.linalg.norm(direction) == pytest.approx(-0.3, abs=0.06)
    assert fastest == pytest.approx(0.15, abs=0.01)


@pytest.mark.parametrize("ahead", [0.4, -0.4])
def test_where_the_side_is_not_told_the_base_goes_back_along_where_it_came_from(ahead):
    harness = Harness(World([FLOOR], []))
    goal = BaseGoal(target=SE3(np.eye(3), np.array([ahead, 0.0, 0.0])), reverse=ahead < 0.0)
    pursue(harness, goal, 3.0)
    before = harness.robot.read().oTb.translation[0]
    bumped = Fault(kind=FaultKind.BUMPER, text="bumped", clearable=True)
    recover = Recover("recover", harness.context)
    for _ in range(3):  # and so when it comes back on the way
        harness.robot.faults = (bumped,)
        while harness.robot.faults:
            harness.tick(recover)
        harness.run_for(recover, 0.7)
        after = harness.robot.read().oTb.translation[0]
        assert (before - after) * np.sign(ahead) > 0.05
        before = after
    harness.robot.faults = (bumped,)
    harness.tick(recover)
    assert harness.context.memory.faults.given_up == "came back 3 times: bumped"


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
    memory = harness.context.memory.faults
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
    assert not harness.context.memory.faults.given_up
    assert (np.diff(times) > [1.99, 7.99, 7.99, 7.99]).all()


def test_a_hand_goes_back_the_way_that_it_came_before_it_rises():
    harness = Harness(table_world())
    harness.run_for(None, 0.1)
    oTe = harness.context.oTe
    ahead = SE3(oTe.rotation, oTe.translation + np.array([0.0, 0.25, 0.0]))
    pursue(harness, PoseGoal(target=ahead, straight=True, speed=0.3), 3.0)
    harness.run_for(None, 0.3)
    hit = harness.context.oTe.translation
    harness.robot.faults = (REFLEX,)
    recover, farthest_back = Recover("recover", harness.context), 0.0
    while harness.run(recover, seconds=0.01) is Status.RUNNING:
        back, up = (harness.context.oTe.translation - hit)[1:]
        if up < 0.02:
            farthest_back = min(farthest_back, back)
    assert recover.status is Status.SUCCESS
    assert farthest_back < -0.03
    assert harness.context.oTe.translation[2] > hit[2] + 0.1
    [stands] = harness.context.memory.faults.hit
    np.testing.assert_allclose(stands.pose.translation, hit, atol=0.01)


def test_a_base_that_has_driven_the_arm_into_something_goes_back_before_the_hand_rises():
    harness = Harness(World([FLOOR], []))
    pursue(harness, BaseGoal(target=SE3(np.eye(3), np.array([2.0, 0.0, 0.0]))), 1.5)
    harness.robot.faults = (REFLEX,)
    recover, hands = Recover("recover", harness.context), []
    memory, stands = harness.context.memory.faults, []
    while not hands or recover.phase != "rise":
        harness.tick(recover)
        hands.append(harness.context.oTe.translation)
        stands.append(len(memory.hit))
    assert hands[-1][0] < max(hand[0] for hand in hands) - 0.2
    assert (stands[0], stands[-1]) == (0, 1), "no obstacle in the hand itself"


@pytest.mark.parametrize(
    ("kind", "lasts"), [(FaultKind.BUMPER, 300.0), (FaultKind.REFLEX, 60.0)], ids=["base", "hand"]
)
def test_what_the_base_hit_stands_there_for_five_minutes_and_what_the_hand_hit_for_one(kind, lasts):
    script = Script()
    memory = script.context.memory.faults
    script.reads(faults=(Fault(kind=kind, text="it hit something", clearable=True),))
    begun = script.clock.now()
    script.reads(hand=up(0.2), faults=())  # what the hand hit stands there once it has left it
    for at, count in ((lasts - 0.1, 1), (lasts + 0.1, 0)):
        script.reads(after=begun + at - script.clock.now())
        assert len(memory.hit) == count


def test_what_was_hit_is_forgotten_when_the_base_is_relocalised():
    harness = unknown_pedestal()
    drive(harness, 1.5)
    assert len(harness.context.surroundings.fixtures) == 2
    same = harness.context.surroundings.fixtures
    harness.tick(None)
    assert harness.context.surroundings.fixtures is same  # or the map would be made at every tick
    harness.context.memory.faults.relocalise()
    assert harness.context.surroundings.fixtures is harness.context.around.fixtures


def test_what_was_hit_and_set_down_stays_on_the_map_while_odometry_drifts():
    harness = unknown_pedestal()
    context = harness.context
    here, seen = context.localisation, []
    for drift in (0.2, 0.7):
        here.mTo = SE3(np.eye(3), np.array([drift, 0.0, 0.0]))
        here.mTb = here.mTo * context.state.oTb
        if not seen:
            drive(harness, 1.5)
            context.memory.set_down.add(0.04, 0.03, context.to_map(context.oTe))
        seen.append((context.surroundings.fixtures[-1], context.surroundings.loose[0]))
    assert seen[1] == seen[0]
    hit, set_down = (one.pose.translation[0] for one in seen[0])
    assert set_down == pytest.approx(context.oTe.translation[0] + 0.2, abs=0.15)
    assert hit > context.state.oTb.translation[0] + 0.2
