"""Contract of every robot, in every world: readings, motion, gripper, camera, closing."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf

import numpy as np
import pytest
from harness import driving

from controller import Command, RobotModel
from hw import Backend, Robot, WorldOptions, open_backend, world_names
from robots import robot_names

PERIOD = 0.01
PATIENCE = 5.0  # longest blocking operation [s]

KINDS = [
    pytest.param(
        (robot, world),
        id=f"{robot}-{world}",
        marks=pytest.mark.slow if (robot, world) == ("omni", "physics") else (),
    )
    for world in world_names()
    for robot in (robot_names() if world != "faulty" else ["frankie"])
]


@dataclass(kw_only=True)
class Driven:
    """A connected robot, and the loop that a session would run."""

    backend: Backend
    ticks: int = 0

    @property
    def robot(self) -> Robot:
        return self.backend.robot

    def run(self, seconds: float, command: Command | None = None) -> None:
        """Tick for a while, sending a command every period or nothing at all."""
        for _ in range(round(seconds / PERIOD)):
            self.robot.read()
            if command is not None:
                self.robot.send(command)
            self.ticks += 1
            self.backend.clock.sleep_until(self.ticks * PERIOD)

    def run_until(self, done) -> None:
        for _ in range(round(PATIENCE / PERIOD)):
            if done():
                return
            self.run(PERIOD)
        raise AssertionError(f"not within {PATIENCE:g} s")


@pytest.fixture(params=KINDS)
def unconnected(request) -> Backend:
    robot, world = request.param
    return open_backend(robot, world, WorldOptions(scene="single", seed=1))


@pytest.fixture
def driven(unconnected) -> Iterator[Driven]:
    with unconnected.robot:
        yield Driven(backend=unconnected)


def joint(number: int, speed: float) -> Command:
    qd = np.zeros(7)
    qd[number] = speed
    return Command(base_twist=np.zeros(3), qd=qd)


def test_a_reading_is_finite_of_the_right_shape_and_within_limits(driven):
    state = driven.robot.read()
    assert state.q.shape == state.qd.shape == (7,)
    assert state.base_twist.shape == (3,)
    for values in (state.q, state.qd, state.base_twist, state.oTb.homogeneous):
        assert np.isfinite(values).all()
    limits = driven.robot.description.limits
    assert ((state.q >= limits.q_min) & (state.q <= limits.q_max)).all()
    assert 0.0 <= state.gripper_width <= driven.robot.description.gripper.opening + 1e-3
    assert state.battery is None or 0.0 <= state.battery <= 1.0
    assert state.faults == ()


def test_stamps_are_those_of_the_session_clock_and_never_go_back(driven):
    stamps = []
    for _ in range(20):
        state = driven.robot.read()
        assert state.stamp <= driven.backend.clock.now() + 1e-9
        assert driven.backend.clock.now() - state.stamp < 0.1
        assert state.stamp == min(state.stamps.arm, state.stamps.base)
        stamps.append(state.stamp)
        driven.run(PERIOD)
    assert stamps == sorted(stamps)
    assert stamps[-1] > stamps[0]


def test_a_reading_is_not_changed_by_what_comes_later(driven):
    before = driven.robot.read()
    kept = before.q.copy(), before.oTb.homogeneous.copy(), before.base_twist.copy()
    driven.run(0.3, driving(0.2))
    driven.run(0.3, joint(5, 0.2))
    for now, then in zip((before.q, before.oTb.homogeneous, before.base_twist), kept, strict=True):
        np.testing.assert_array_equal(now, then)


def test_base_and_joints_follow_and_sending_returns_what_was_applied(driven):
    start = driven.robot.read()
    driven.run(1.0, driving(0.2))
    moved = start.oTb.actInv(driven.robot.read().oTb).translation
    assert 0.1 < moved[0] < 0.25
    assert abs(moved[1]) < 0.02
    start = driven.robot.read()
    driven.run(1.0, joint(5, 0.2))
    turned = driven.robot.read().q - start.q
    assert 0.15 < turned[5] < 0.25
    assert np.abs(np.delete(turned, 5)).max() < 0.01
    command = driving(0.1)
    applied = driven.robot.send(command)
    np.testing.assert_allclose(applied.base_twist, command.base_twist)
    np.testing.assert_allclose(applied.qd, command.qd)


@pytest.mark.parametrize("how", ["no command", "stop"])
def test_without_a_command_the_robot_comes_to_rest(driven, how):
    driven.run(0.5, driving(0.2))
    driven.run(0.3, joint(5, 0.2))
    if how == "stop":
        driven.robot.stop()
    driven.run(1.5)
    state = driven.robot.read()
    assert np.abs(state.base_twist).max() < 1e-3
    assert np.abs(state.qd).max() < 1e-3


def test_a_grip_starts_at_once_tells_when_it_has_ended_and_does_not_stop_the_base(driven):
    opening = driven.robot.description.gripper.opening
    for width in (0.5 * opening, 0.0, opening):
        driven.robot.grip(width, 20.0)
        if width:
            assert driven.robot.read().gripper_moving
        driven.run_until(lambda: not driven.robot.read().gripper_moving)
        if width:
            assert driven.robot.read().gripper_width == pytest.approx(width, abs=2e-3)
    start = driven.robot.read().oTb
    driven.robot.grip(0.0, 20.0)
    driven.run(0.8, driving(0.2))
    assert start.actInv(driven.robot.read().oTb).translation[0] > 0.03


def test_recovering_a_healthy_robot_ends_and_leaves_it_healthy(driven):
    driven.robot.recover()
    driven.run_until(lambda: not driven.robot.read().recovering)
    assert driven.robot.read().faults == ()


def wait_for_frame(driven: Driven, after=None):
    driven.run_until(lambda: driven.robot.camera.latest(inf) not in (None, after))
    return driven.robot.camera.latest(inf)


def test_a_frame_fits_the_description_and_stays_one_object_until_a_newer_one(driven):
    first = wait_for_frame(driven)
    intrinsics = driven.robot.description.camera.intrinsics
    assert first.depth.shape == (intrinsics.height, intrinsics.width)
    assert first.intrinsics == intrinsics
    assert (first.depth[np.isfinite(first.depth)] > 0.0).all()
    assert driven.robot.camera.latest(inf) is first
    second = wait_for_frame(driven, after=first)
    assert second.stamp > first.stamp
    age = driven.backend.clock.now() - second.stamp
    assert driven.robot.camera.latest(age + 1.0) is not None
    assert driven.robot.camera.latest(-1.0) is None


def test_a_frame_knows_where_it_was_captured(driven):
    """Also when it comes late: the pose is that of the stamp, not of now."""
    model = RobotModel(driven.robot.description)
    first = wait_for_frame(driven)
    states = [driven.robot.read()]
    while (frame := driven.robot.camera.latest(inf)) is first or len(states) <= 40:
        driven.robot.send(driving(0.2))
        driven.run(PERIOD)
        states.append(driven.robot.read())
        assert len(states) < PATIENCE / PERIOD, "no other frame came"
    then = min(states, key=lambda state: abs(state.stamp - frame.stamp))
    oTc = model.end_effector(then.oTb, then.q) * driven.robot.description.camera.eTc
    distance = np.linalg.norm(oTc.translation - frame.oTc.translation)
    assert distance < 0.2 * PERIOD + 1e-6  # a period at 0.2 m/s
