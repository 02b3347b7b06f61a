"""A robot of parts with readings of different stamps, blocking operations and failures."""

import threading
from collections.abc import Callable
from math import inf

import numpy as np
import pinocchio as pin
import pytest

from controller import robot_model
from hw import (
    ArmState,
    BaseState,
    ComposedRobot,
    DepthImage,
    FaultKind,
    GripperState,
    HardwareError,
    LaserReading,
    SimClock,
)
from hw.composition import History, _interpolate_arm
from hw.threads import one_thread
from robots import load_robot

FRANKIE = load_robot("frankie")
SPEED, RATE = 0.5, 0.4  # of the base along x [m/s], of its rotation and every joint [rad/s]


def arm_at(stamp: float) -> ArmState:
    return ArmState(stamp=stamp, q=FRANKIE.arm.ready + RATE * stamp, qd=np.full(7, RATE))


def base_at(stamp: float) -> BaseState:
    twist = np.array([SPEED, 0.0, RATE])
    oTb = pin.exp6(np.array([SPEED, 0.0, 0.0, 0.0, 0.0, RATE]) * stamp)
    return BaseState(stamp=stamp, oTb=oTb, twist=twist)


def gripper_at(stamp: float) -> GripperState:
    return GripperState(stamp=stamp, width=0.04, moving=False)


class Part:
    """A driver whose readings lag and whose operations block until `gate` is set."""

    def __init__(self, clock: SimClock, at: Callable = lambda stamp: None, lag: float = 0.0):
        self.clock, self.at, self.lag = clock, at, lag
        self.log: list[str] = []
        self.unreachable = self.error = ""
        self.gate = threading.Event()
        self.image: DepthImage | None = None

    def read(self):
        return self.at(self.clock.now() - self.lag)

    def send(self, velocities):
        return velocities

    def latest(self):
        return self.image

    def faults(self):
        return ()

    def connect(self):
        self.log.append("connect")
        if self.unreachable:
            raise HardwareError(self.unreachable)

    def close(self):
        self.log.append("close")

    def stop(self):
        self.log.append("stop")
        if self.error:
            raise HardwareError(self.error)

    def recover(self):
        self.gate.wait(5.0)
        self.log.append("recover")

    def grip(self, width, force):
        self.gate.wait(5.0)
        self.log.append(f"grip {width:g}")
        if self.error:
            raise HardwareError(self.error)


class Assembly:
    def __init__(self, arm_lag: float = 0.0, base_lag: float = 0.0) -> None:
        self.clock = SimClock()
        self.arm, self.base = Part(self.clock, arm_at, arm_lag), Part(self.clock, base_at, base_lag)
        self.gripper, self.camera = Part(self.clock, gripper_at), Part(self.clock)
        self.laser = Part(self.clock)
        self.parts = (self.arm, self.base, self.gripper, self.camera)
        parts = zip(("arm", "base", "gripper", "camera"), self.parts, strict=True)
        self.robot = ComposedRobot(
            FRANKIE, clock=self.clock, laser=self.laser, background=one_thread, **dict(parts)
        )

    def unblock(self) -> None:
        for part in self.parts:
            part.gate.set()

    def finish(self) -> None:
        """Let the blocked operations end."""
        self.unblock()
        self.robot._grips.shutdown(wait=True)
        self.robot._recoveries.shutdown(wait=True)

    def run(self, until: float) -> None:
        while self.clock.now() < until - 1e-9:
            self.robot.read()
            self.clock.sleep_until(self.clock.now() + 0.01)


@pytest.mark.parametrize(("arm_lag", "base_lag"), [(0.0, 0.043), (0.031, 0.004), (0.0, 0.0)])
def test_arm_and_base_are_of_the_same_moment(arm_lag, base_lag):
    built = Assembly(arm_lag, base_lag)
    built.run(0.5)
    state = built.robot.read()
    older = 0.5 - max(arm_lag, base_lag)
    assert state.stamp == pytest.approx(older)
    np.testing.assert_allclose(state.q, arm_at(older).q, atol=1e-9)
    assert state.oTb.isApprox(base_at(older).oTb, 1e-6)
    assert state.stamps == pytest.approx((0.5 - arm_lag, 0.5 - base_lag, 0.5))


def test_frames_and_scans_have_the_poses_at_their_capture():
    built = Assembly(base_lag=0.02)
    built.run(0.5)
    camera, laser, captured = built.robot.camera, built.robot.laser, 0.437
    assert camera.latest(inf) is laser.latest(inf) is None
    built.camera.image = DepthImage(depth=np.ones((480, 640), np.float32), stamp=captured)
    points = np.array([[1.0, 0.2, 0.19]])
    built.laser.image = LaserReading(stamp=captured, ranges=np.array([0.8]), points=points)
    frame, scan = camera.latest(inf), laser.latest(inf)
    oTe = robot_model("frankie").end_effector(base_at(captured).oTb, arm_at(captured).q)
    assert frame.oTc.isApprox(oTe * FRANKIE.camera.eTc, 1e-4)
    assert scan.oTb.isApprox(base_at(captured).oTb, 1e-4)
    assert scan.points is points
    for sensor, one in ((camera, frame), (laser, scan)):
        assert one.stamp == captured
        assert sensor.latest(inf) is one
        assert sensor.latest(0.05) is None


def test_operations_do_not_block_readings_and_are_not_started_twice():
    built = Assembly()
    built.robot.grip(0.02, 20.0)
    built.robot.recover()
    built.robot.recover()
    state = built.robot.read()
    assert state.gripper_moving
    assert state.recovering
    assert "recover" not in built.arm.log
    built.finish()
    state = built.robot.read()
    assert not state.gripper_moving
    assert not state.recovering
    assert built.arm.log == built.base.log == ["recover"]
    assert sorted(built.gripper.log) == ["grip 0.02", "recover"]


def test_the_arm_is_not_recovered_twice_in_two_seconds():
    built = Assembly()
    built.unblock()
    recovered = []
    for _ in range(90):
        built.robot.recover()
        while built.robot.read().recovering:
            pass
        recovered += [built.clock.now()] * (built.arm.log.count("recover") - len(recovered))
        built.clock.sleep_until(built.clock.now() + 0.05)
    assert len(recovered) == 3
    assert np.diff(recovered).min() > 2.0 - 1e-6
    assert built.base.log.count("recover") > 80


def test_a_grip_that_failed_is_a_fault_until_the_next_recovery():
    built = Assembly()
    built.gripper.error = "the fingers are blocked"
    built.unblock()
    built.robot.grip(0.0, 20.0)
    built.robot._grips.shutdown(wait=True)
    [fault] = built.robot.read().faults
    assert (fault.kind, fault.clearable) == (FaultKind.OPERATION, True)
    assert fault.text == "grip failed: the fingers are blocked"
    built.robot.recover()
    built.finish()
    assert built.robot.read().faults == ()


def test_a_part_that_cannot_be_reached_is_named_and_the_others_are_closed():
    built = Assembly()
    built.gripper.unreachable = "the hand does not answer at 172.16.0.2: is it switched on?"
    with pytest.raises(HardwareError, match="the hand does not answer"), built.robot:
        pass
    assert built.arm.log == built.base.log == ["connect", "close"]
    assert built.camera.log == []


def test_the_history_of_a_part_is_interpolated_inside_and_ends_at_its_last_reading():
    history = History(_interpolate_arm)

    def add(stamp, value):
        history.add(ArmState(stamp=stamp, q=np.full(7, value), qd=np.zeros(7)))

    def value(stamp):
        return history.at(stamp).q[0]

    for number in range(6):
        add(0.1 * number, 10.0 * number)
    assert value(0.33) == pytest.approx(33.0)
    assert (value(-1.0), value(9.0)) == (0.0, 50.0)
    add(0.5, 99.0)  # a reading of the same or an earlier stamp replaces later ones
    assert value(0.5) == 99.0
    assert value(0.45) == pytest.approx((40.0 + 99.0) / 2)
    add(0.25, 25.0)
    assert value(9.0) == 25.0
    assert value(0.225) == pytest.approx(22.5)
    add(2.0, 7.0)  # older readings are dropped
    assert value(0.0) == 7.0
