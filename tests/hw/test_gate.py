"""The gate lets good commands through untouched and turns every other into braking."""

from dataclasses import replace

import numpy as np
import pytest
from pinocchio import SE3

from controller import Command
from hw import Fault, FaultKind, Gate, Refusal, RobotState
from robots import load_robot

FRANKIE = load_robot("frankie")
READY = load_robot("frankie").arm.ready

LIMITS = FRANKIE.limits
DT = 0.01


class Wire:
    """Where hardware would stand: remembers what reached it."""

    def __init__(self) -> None:
        self.sent: list[Command] = []

    def send(self, command: Command) -> Command:
        self.sent.append(command)
        return command


def reading(stamp: float = 0.0, q=READY, faults=()) -> RobotState:
    return RobotState(
        stamp=stamp,
        wTb=SE3.Identity(),
        base_twist=np.zeros(3),
        q=np.asarray(q),
        qd=np.zeros(7),
        gripper_width=0.08,
        gripper_moving=False,
        faults=tuple(faults),
    )


def command(base=(0.0, 0.0, 0.0), qd=0.0) -> Command:
    return Command(base_twist=np.array(base, dtype=float), qd=np.full(7, float(qd)))


@pytest.fixture
def wire() -> Wire:
    return Wire()


@pytest.fixture
def gate(wire) -> Gate:
    return Gate(wire, LIMITS, DT)


def test_a_good_command_passes_unchanged(gate, wire):
    good = command((0.015, 0.0, 0.03), 0.06)
    assert gate.send(good, reading(), 0.0) is good
    assert wire.sent == [good]
    assert not any(gate.refusals.values())


def test_a_reverse_speed_of_its_own_is_kept(wire):
    gate = Gate(wire, replace(LIMITS, base_reverse=0.01), DT)
    assert gate.send(command((-0.012, 0.0, 0.0)), reading(), 0.0).base_twist[0] == 0.0
    assert gate.refusals[Refusal.SPEED] == 1
    slow = command((-0.009, 0.0, 0.0))
    assert gate.send(slow, reading(), 0.0) is slow
    forward = command((0.006, 0.0, 0.0))
    assert gate.send(forward, reading(), 0.0) is forward


def spun_up(gate: Gate) -> None:
    """Bring the robot to 0.15 m/s and 0.3 rad/s in ten lawful steps."""
    for k in range(1, 11):
        gate.send(command((0.015 * k, 0.0, 0.0), 0.03 * k), reading(), 0.0)
    assert gate.applied.base_twist[0] == pytest.approx(0.15)


FAULT = Fault(kind=FaultKind.REFLEX, text="touched something", clearable=True)


@pytest.mark.parametrize(
    ("bad", "state", "reason"),
    [
        (command((np.nan, 0, 0), 0.3), reading(), Refusal.NOT_FINITE),
        (command((0.15, 0, 0), np.inf), reading(), Refusal.NOT_FINITE),
        (command((1e300, 0, 0), 0.3), reading(), Refusal.SPEED),
        (command((0.15, 0.01, 0), 0.3), reading(), Refusal.SPEED),  # wheels do not go sideways
        (command((0.15, 0, 0), 2.2), reading(), Refusal.SPEED),
        (command((0.15, 0, 0), 0.4), reading(), Refusal.ACCELERATION),
        (command((0.30, 0, 0), 0.3), reading(), Refusal.ACCELERATION),
        (command((0.15, 0, 0), 0.3), reading(q=LIMITS.q_max - 0.001), Refusal.POSITION),
        (command((0.15, 0, 0), 0.3), reading(faults=[FAULT]), Refusal.FAULT),
        (command((0.15, 0, 0), 0.3), reading(stamp=-0.2), Refusal.STALE_STATE),
        (command((0.15, 0, 0), 0.3), reading(stamp=np.nan), Refusal.STALE_STATE),
    ],
)
def test_a_bad_command_never_arrives_and_the_robot_brakes_instead(gate, wire, bad, state, reason):
    spun_up(gate)
    before = gate.applied
    after = gate.send(bad, state, 0.0)
    assert gate.refusals[reason] == 1
    assert after.is_finite()
    assert after.base_twist[0] == pytest.approx(before.base_twist[0] - 1.5 * DT)
    np.testing.assert_allclose(after.qd, before.qd - LIMITS.qdd * DT)


def test_braking_ends_at_rest_without_overshoot(gate):
    spun_up(gate)
    for _ in range(30):
        gate.send(command((np.nan, 0, 0)), reading(), 0.0)
    assert not gate.applied.base_twist.any()
    assert not gate.applied.qd.any()


def test_an_emergency_stop_is_latched_until_it_is_released(gate):
    button = Fault(kind=FaultKind.EMERGENCY_STOP, text="button pressed", clearable=False)
    small = command((0.01, 0.0, 0.0))
    gate.send(small, reading(faults=[button]), 0.0)
    assert not gate.send(small, reading(), 0.0).base_twist.any()
    assert gate.refusals[Refusal.EMERGENCY_STOP] == 2
    gate.release()
    assert gate.send(small, reading(), 0.0) is small


def test_a_joint_beyond_its_range_may_still_come_back(gate):
    inwards = command(qd=-0.05)
    assert gate.send(inwards, reading(q=LIMITS.q_max + 0.1), 0.0) is inwards
