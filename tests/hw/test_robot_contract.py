"""What any robot must do, whatever moves it: every body in every world keeps the same contract.

A robot that stands here has a scene with a table in front of it; nothing else is assumed. A driver
or another simulator joins by adding its world to the registry and, if it needs one, a line below.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from math import inf

import numpy as np
import pytest

from controller import Command, RobotModel
from hw import Backend, HardwareError, Robot, WorldOptions, open_backend
from hw.registry import WORLDS
from robots import robot_names

PERIOD = 0.01
PATIENCE = 5.0
"""What takes time on a robot is over after this [s]."""

KINDS = [
    pytest.param((robot, world, beside), id=f"{robot}-{world}{'-beside' if beside else ''}")
    for world in WORLDS
    for robot in robot_names()
    for beside in (False, True)
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
            time.sleep(1e-4)  # for the threads beside a loop whose time is simulated
        raise AssertionError(f"not within {PATIENCE:g} s")


@pytest.fixture(params=KINDS)
def unconnected(request) -> Backend:
    robot, world, beside = request.param
    return open_backend(robot, world, WorldOptions(scene="single", seed=1, beside=beside))


@pytest.fixture
def driven(unconnected) -> Iterator[Driven]:
    with unconnected.robot:
        yield Driven(backend=unconnected)


def forward(robot: Robot, speed: float = 0.2) -> Command:
    return Command(base_twist=np.array([speed, 0.0, 0.0]), qd=np.zeros(7))


def joint(number: int, speed: float) -> Command:
    qd = np.zeros(7)
    qd[number] = speed
    return Command(base_twist=np.zeros(3), qd=qd)


# readings


def test_a_reading_is_finite_and_of_the_right_shape(driven):
    state = driven.robot.read()
    assert state.q.shape == state.qd.shape == (7,)
    assert state.base_twist.shape == (3,)
    for values in (state.q, state.qd, state.base_twist, state.wTb.homogeneous):
        assert np.isfinite(values).all()
    assert 0.0 <= state.gripper_width <= driven.robot.description.gripper.opening + 1e-3
    assert state.battery is None or 0.0 <= state.battery <= 1.0
    assert state.faults == ()


def test_the_arm_begins_inside_its_limits(driven):
    limits, q = driven.robot.description.limits, driven.robot.read().q
    assert ((q >= limits.q_min) & (q <= limits.q_max)).all()


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
    kept = before.q.copy(), before.wTb.homogeneous.copy(), before.base_twist.copy()
    driven.run(0.3, forward(driven.robot))
    driven.run(0.3, joint(5, 0.2))
    for now, then in zip((before.q, before.wTb.homogeneous, before.base_twist), kept, strict=True):
        np.testing.assert_array_equal(now, then)


# motion


def test_the_base_follows_a_twist(driven):
    start = driven.robot.read().wTb
    driven.run(1.0, forward(driven.robot))
    moved = start.actInv(driven.robot.read().wTb).translation
    assert 0.1 < moved[0] < 0.25
    assert abs(moved[1]) < 0.02


def test_a_joint_follows_its_velocity_and_the_others_stay(driven):
    start = driven.robot.read().q
    driven.run(1.0, joint(5, 0.2))
    moved = driven.robot.read().q - start
    assert 0.15 < moved[5] < 0.25
    assert np.abs(np.delete(moved, 5)).max() < 0.01


def test_sending_returns_what_was_applied(driven):
    command = forward(driven.robot, 0.1)
    applied = driven.robot.send(command)
    np.testing.assert_allclose(applied.base_twist, command.base_twist)
    np.testing.assert_allclose(applied.qd, command.qd)


@pytest.mark.parametrize("how", ["no command", "stop"])
def test_without_a_command_the_robot_comes_to_rest(driven, how):
    driven.run(0.5, forward(driven.robot))
    driven.run(0.3, joint(5, 0.2))
    if how == "stop":
        driven.robot.stop()
    driven.run(1.5)
    state = driven.robot.read()
    assert np.abs(state.base_twist).max() < 1e-3
    assert np.abs(state.qd).max() < 1e-3


# what takes time


def test_a_grip_is_started_at_once_and_tells_when_it_has_ended(driven):
    half = 0.5 * driven.robot.description.gripper.opening
    driven.robot.grip(half, 20.0)
    assert driven.robot.read().gripper_moving
    driven.run_until(lambda: not driven.robot.read().gripper_moving)
    assert driven.robot.read().gripper_width == pytest.approx(half, abs=2e-3)


def test_the_fingers_open_again(driven):
    opening = driven.robot.description.gripper.opening
    driven.robot.grip(0.0, 20.0)
    driven.run_until(lambda: not driven.robot.read().gripper_moving)
    driven.robot.grip(opening, 20.0)
    driven.run_until(lambda: not driven.robot.read().gripper_moving)
    assert driven.robot.read().gripper_width == pytest.approx(opening, abs=2e-3)


def test_a_grip_does_not_keep_the_robot_from_moving(driven):
    start = driven.robot.read().wTb
    driven.robot.grip(0.0, 20.0)
    driven.run(0.8, forward(driven.robot))
    assert start.actInv(driven.robot.read().wTb).translation[0] > 0.03


def test_recovering_a_healthy_robot_ends_and_leaves_it_healthy(driven):
    driven.robot.recover()
    driven.run_until(lambda: not driven.robot.read().recovering)
    assert driven.robot.read().faults == ()


# the camera


def wait_for_frame(driven: Driven, after=None):
    def there() -> bool:
        time.sleep(0.002)  # what runs beside the loop gets its turn
        return driven.robot.camera.latest(inf) not in (None, after)

    driven.run_until(there)
    return driven.robot.camera.latest(inf)


def test_a_frame_is_what_the_description_says(driven):
    frame = wait_for_frame(driven)
    intrinsics = driven.robot.description.camera.intrinsics
    assert frame.depth.shape == (intrinsics.height, intrinsics.width)
    assert frame.intrinsics == intrinsics
    seen = frame.depth[np.isfinite(frame.depth)]
    assert (seen > 0.0).all()


def test_a_frame_stays_the_same_object_until_there_is_a_newer_one(driven):
    first = wait_for_frame(driven)
    assert driven.robot.camera.latest(inf) is first
    second = wait_for_frame(driven, after=first)
    assert second is not first
    assert second.stamp > first.stamp


def test_a_frame_knows_where_it_was_captured(driven):
    """Also when it comes late: the pose is that of the stamp, not of now."""
    model = RobotModel(driven.robot.description)
    first = wait_for_frame(driven)
    states = [driven.robot.read()]
    while (frame := driven.robot.camera.latest(inf)) is first or len(states) <= 40:
        driven.robot.send(forward(driven.robot))
        driven.run(PERIOD)
        time.sleep(0.002)  # what runs beside the loop gets its turn
        states.append(driven.robot.read())
        assert len(states) < PATIENCE / PERIOD, "no other frame came"
    then = min(states, key=lambda state: abs(state.stamp - frame.stamp))
    wTc = model.wTe(then.wTb, then.q) * driven.robot.description.camera.eTc
    distance = np.linalg.norm(wTc.translation - frame.wTc.translation)
    assert distance < 0.2 * PERIOD + 1e-6  # a period at 0.2 m/s


def test_a_frame_that_is_too_old_is_none(driven):
    frame = wait_for_frame(driven)
    age = driven.backend.clock.now() - frame.stamp
    assert driven.robot.camera.latest(age + 1.0) is not None
    assert driven.robot.camera.latest(-1.0) is None


# beginning and end


def test_closing_twice_is_allowed_and_stops_the_robot(driven):
    driven.run(0.3, forward(driven.robot))
    driven.robot.close()
    driven.robot.close()


def test_the_context_manager_closes_whatever_happens(unconnected):
    def unplugged() -> None:
        raise HardwareError("cable")

    with pytest.raises(HardwareError, match="cable"), unconnected.robot:
        unplugged()


def test_what_is_known_of_the_world_fits_together(driven):
    truth = driven.backend.truth
    if truth is None:
        pytest.skip("nobody knows the world of this robot")
    names = [one.name for one in truth.objects]
    assert len(set(names)) == len(names) > 0
    assert set(truth.supports()) == set(names)
    assert all(np.isfinite(one.pose.homogeneous).all() for one in truth.objects)
    assert all(geom.name for geom in truth.fixtures)
