"""What the world tells late, and where it is not what it was: late frames, jumps of the base."""

from collections import deque
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from ended import failure
from harness import SPOT, Harness, block, held_block, open_floor, over_the_table, table_world
from pinocchio import SE3
from py_trees.common import Status

from behaviours import BasePose
from behaviours.core.relocalisation import Relocalisation
from behaviours.drive import Drive
from behaviours.grasp import Grasp
from behaviours.place import Place
from hw.state import LocalisedPose


class LateCamera:
    """Delivers every frame some time after it was captured."""

    def __init__(self, harness: Harness, late: float) -> None:
        self._camera, self._clock, self._late = harness.robot.camera, harness.clock, late
        self._frames: deque = deque()

    def latest(self, max_age: float):
        self._frames.append(self._camera.latest(max_age))
        due = self._clock.now() - self._late
        while len(self._frames) > 1 and self._frames[1].stamp <= due + 1e-6:
            self._frames.popleft()
        return self._frames[0] if self._frames[0].stamp <= due + 1e-6 else None


def with_late_frames(late: float) -> Harness:
    harness = over_the_table(block(x=0.75))
    camera = LateCamera(harness, late)
    harness.context.vision._camera = camera
    for _ in range(60):
        camera.latest(1.0)
        harness.run_for(None, 0.01)
    return harness


def test_late_frames_give_a_grasp_where_nothing_moves_and_none_within_a_second_is_told():
    harness = with_late_frames(0.6)
    assert harness.run(Grasp("grasp", harness.context, within=SPOT)) is Status.SUCCESS
    assert harness.world.held is not None
    harness = with_late_frames(1.2)
    leaf = Grasp("grasp", harness.context, within=SPOT)
    assert "no camera frame" in failure(harness, leaf, seconds=2.0)


def displace(harness: Harness, metres: float, degrees: float = 0.0) -> None:
    """The base believes from now on that it is somewhere else along the table."""
    read = harness.robot.read
    along = SE3(np.eye(3), np.array([0.0, metres, 0.0]))
    turned = SE3(pin.utils.rotate("z", np.radians(degrees)), np.zeros(3))
    harness.robot.read = lambda: replace(state := read(), oTb=along * state.oTb * turned)


def test_a_grasp_that_was_locked_is_looked_for_again_after_a_jump():
    harness = over_the_table(block(x=0.75))
    leaf = Grasp("grasp", harness.context, within=SPOT)
    harness.run_into(leaf, "lock")
    displace(harness, 0.1)
    harness.tick(leaf)
    assert harness.context.now.relocalised == "the base was relocalised by 0.10 m and 0°"
    assert leaf.phase == "approach"


def test_a_hand_that_goes_down_stops_after_a_jump():
    harness = over_the_table(block(x=0.75))
    leaf = Grasp("grasp", harness.context, within=SPOT)
    harness.run_into(leaf, "descend")
    displace(harness, 0.0, 5.0)
    before = harness.context.oTe.translation[2]
    harness.tick(leaf)
    assert leaf.phase == "rise"
    assert failure(harness, leaf).startswith("the base was relocalised by")
    assert harness.context.oTe.translation[2] > before + 0.05
    assert not harness.context.vision.tracker.locked


def test_an_object_is_not_lowered_where_the_place_is_no_longer():
    harness = held_block()
    leaf = Place("place", harness.context, on=SPOT, pitch_m=0.13)
    harness.run_into(leaf, "lower")
    displace(harness, 0.05)
    harness.tick(leaf)
    assert leaf.phase == "approach"
    assert harness.run(leaf) is Status.SUCCESS


def test_a_jump_during_a_pause_is_told_by_the_next_tick():
    harness = Harness(table_world())
    harness.run_for(None, 0.5)
    displace(harness, 0.1)
    harness.context.read(harness.robot.read())
    harness.run_for(None, 0.01)
    assert harness.context.now.relocalised
    harness.run_for(None, 0.01)
    assert not harness.context.now.relocalised


class Contradicted:
    """The harness with odometry and a localisation of its own, which a test may displace."""

    def __init__(self) -> None:
        self.harness = Harness(open_floor())
        self.off = SE3.Identity()
        self._read, self.harness.robot.read = self.harness.robot.read, self._reading

    def _reading(self):
        state = self._read()
        mTb = self.off * state.oTb
        covariance = np.diag([0.02, 0.02, 0.01]) ** 2
        localised = LocalisedPose(stamp=state.stamp, mTb=mTb, covariance=covariance)
        return replace(state, localised=localised)


def test_motions_stop_while_the_localisation_contradicts_itself_and_go_on_afterwards():
    run = Contradicted()
    harness, context = run.harness, run.harness.context
    goal = BasePose(name="there", mTb=SE3(np.eye(3), np.array([3.0, 0.0, 0.0])))
    leaf = Drive("drive", context, to=context.on_map(goal))
    harness.run_for(leaf, 0.5)
    run.off = SE3(np.eye(3), np.array([0.0, 0.5, 0.0]))
    harness.run_for(leaf, 2.5)
    assert leaf.status is Status.RUNNING
    told = "waiting: the base's own localisation has it 0.50 m and 0° away: it is not certain"
    assert leaf.feedback_message.startswith(told)
    assert np.abs(context.state.base_twist).max() < 0.01
    run.off = SE3.Identity()
    harness.run_for(leaf, 0.5)
    assert "waiting" not in leaf.feedback_message
    assert context.state.base_twist[0] > 0.1
    assert not context.log.messages


def test_a_base_that_insists_with_nothing_in_sight_was_carried():
    run = Contradicted()
    harness, context = run.harness, run.harness.context
    jumps = []
    for tick in range(650):
        context.begin_tick(harness.robot.read())
        harness.clock.sleep_until(0.01 * tick)
        if tick == 50:
            run.off = SE3(np.eye(3), np.array([0.0, 0.5, 0.0]))
        jumps += [context.now.relocalised] * bool(context.now.relocalised)
    told = "the base was relocalised by 0.50 m and 0°: nothing in sight speaks against it"
    assert jumps == [told]
    assert [text for _, text in context.log.messages] == jumps
    assert not context.localisation.doubt
    assert context.localisation.mTb.translation[1] == pytest.approx(0.5, abs=0.02)


def readings(harness: Harness, seconds: float, twist: np.ndarray) -> list:
    """What the robot tells while its base moves with a twist."""
    seen = []
    for _ in range(round(seconds * 100)):
        seen.append(harness.robot.read())
        harness.robot.send(replace(harness.gate.applied, base_twist=twist))
        harness.clock.sleep_until(harness.clock.now() + 0.01)
    return seen


def test_motion_gaps_and_the_first_reading_are_no_jumps():
    seen = readings(Harness(table_world()), 3.0, np.array([1.0, 0.0, 1.0]))
    for told in (seen, seen[::40]):  # gaps of 0.4 s
        relocalisation = Relocalisation()
        assert not any(relocalisation.note(state) for state in told)


def test_a_jump_that_is_spread_over_some_readings_is_one_jump():
    """As interpolation between the readings of a slow base does."""
    seen = readings(Harness(table_world()), 1.0, np.array([0.5, 0.0, 0.0]))
    relocalisation = Relocalisation()
    told = 0
    for number, state in enumerate(seen):
        away = SE3(np.eye(3), np.array([0.0, 0.005 * np.clip(number - 50, 0, 8), 0.0]))
        told += bool(relocalisation.note(replace(state, oTb=state.oTb * away)))
    assert told == 1
