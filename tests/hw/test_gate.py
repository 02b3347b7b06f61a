"""Command gate: valid commands pass unchanged, all others become braking."""

import re
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from gate_stand import DT, FRANKIE, LIMITS, READY, Stand, command, untrusted
from pinocchio import SE3

from controller import Command
from hw import Fault, FaultKind, Refusal, UntrustedRobotError
from hw.state import LocalisedPose, PartStamps


@pytest.fixture
def stand() -> Stand:
    return Stand()


REFLEX = Fault(kind=FaultKind.REFLEX, text="touched something", clearable=True)
BUTTON = Fault(kind=FaultKind.EMERGENCY_STOP, text="button pressed", clearable=False)


def test_a_valid_command_passes_unchanged(stand):
    good = command((0.015, 0.0, 0.03), 0.06)
    assert stand.send(good) is good
    assert stand.wire.sent == [good]
    assert not any(stand.gate.refusals.values())


def test_a_reverse_speed_of_its_own_is_kept():
    stand = Stand(replace(FRANKIE, limits=replace(LIMITS, base_reverse=0.01)))
    assert stand.send(command((-0.012, 0.0, 0.0))).base_twist[0] == 0.0
    assert stand.gate.refusals[Refusal.SPEED] == 1
    slow = command((-0.009, 0.0, 0.0))
    assert stand.send(slow) is slow
    forward = command((0.006, 0.0, 0.0))
    assert stand.send(forward) is forward


def localised(x: float = 0.0, covariance=None) -> LocalisedPose:
    covariance = np.zeros((3, 3)) if covariance is None else covariance
    return LocalisedPose(stamp=0.0, mTb=SE3(np.eye(3), np.array([x, 0, 0])), covariance=covariance)


GOING = command((0.15, 0, 0), 0.3)
BAD = [
    (command((np.nan, 0, 0), 0.3), {}, Refusal.NOT_FINITE),
    (command((0.15, 0, 0), np.inf), {}, Refusal.NOT_FINITE),
    (Command(base_twist=np.zeros(2), qd=np.zeros(7)), {}, Refusal.NOT_FINITE),
    (command((1e300, 0, 0), 0.3), {}, Refusal.SPEED),
    (command((0.15, 0.01, 0), 0.3), {}, Refusal.SPEED),  # wheels do not go sideways
    (command((0.15, 0, 0), 2.2), {}, Refusal.SPEED),
    (command((0.15, 0, 0), 0.5), {}, Refusal.ACCELERATION),
    (command((0.30, 0, 0), 0.3), {}, Refusal.ACCELERATION),
    (GOING, {"faults": (REFLEX,)}, Refusal.FAULT),
    (GOING, {"faults": (BUTTON,)}, Refusal.EMERGENCY_STOP),
    (GOING, {"stamp": -0.2}, Refusal.READING),
    (GOING, {"stamp": np.nan}, Refusal.READING),
    (GOING, {"stamp": 3600.0}, Refusal.READING),
    (GOING, {"q": np.full(7, np.nan)}, Refusal.READING),
    (GOING, {"q": READY[:6]}, Refusal.READING),
    (GOING, {"q": READY + 1.0}, Refusal.READING),  # a jump that no joint can make
    (GOING, {"q": np.full(7, 9.0)}, Refusal.READING),
    (GOING, {"qd": np.full(7, np.inf)}, Refusal.READING),
    (GOING, {"qd": np.full(7, 50.0)}, Refusal.READING),
    (GOING, {"base_twist": np.array([np.nan, 0, 0])}, Refusal.READING),
    (GOING, {"wTb": SE3(2.0 * np.eye(3), np.zeros(3))}, Refusal.READING),
    (GOING, {"wTb": SE3(np.eye(3), np.array([np.nan, 0, 0]))}, Refusal.READING),
    (GOING, {"gripper_width": np.nan}, Refusal.READING),
    (GOING, {"battery": np.nan}, Refusal.READING),
    (GOING, {"localised": localised(x=np.nan)}, Refusal.READING),
    (GOING, {"localised": localised(covariance=np.full((3, 3), np.nan))}, Refusal.READING),
    (GOING, {"localised": localised(covariance=-np.eye(3))}, Refusal.READING),
    (GOING, {"localised": localised(covariance=np.eye(2))}, Refusal.READING),
]


@pytest.mark.parametrize(("bad", "changes", "reason"), BAD)
def test_a_bad_command_or_reading_makes_the_robot_brake_instead(stand, bad, changes, reason):
    stand.spin_up()
    before = stand.gate.applied
    after = stand.send(bad, **changes)
    assert stand.gate.refusals[reason] == 1
    assert after.is_finite()
    assert after.base_twist[0] == pytest.approx(
        before.base_twist[0] - LIMITS.base_emergency[0] * DT
    )
    np.testing.assert_allclose(after.qd, before.qd - LIMITS.qdd * DT)


def test_a_joint_that_could_not_stop_within_its_range_is_braked(stand):
    stand.q = LIMITS.q_max - 0.02
    for k in range(1, 40):
        stand.send(command(qd=min(0.06 * k, 2.0)))
    assert stand.gate.refusals[Refusal.POSITION] > 0
    assert (stand.q <= LIMITS.q_max).all()


def test_braking_ends_at_rest_without_overshoot(stand):
    stand.spin_up()
    for _ in range(30):
        stand.send(command((np.nan, 0, 0)))
    assert not stand.gate.applied.base_twist.any()
    assert not stand.gate.applied.qd.any()
    stand = Stand()
    stand.spin_up()
    assert not stand.gate.brake(None, stand.now + 1.0).base_twist.any()  # after a gap


def test_commands_at_one_instant_share_one_change_of_velocity(stand):
    reading = stand.reading()
    for k in range(1, 6):
        stand.gate.send(command((0.015 * k, 0.0, 0.0), 0.06 * k), reading, 0.0)
    assert stand.gate.applied.base_twist[0] <= 2.0 * LIMITS.base_acceleration[0] * DT + 1e-9
    assert stand.gate.refusals[Refusal.ACCELERATION] >= 1


def test_after_a_gap_the_command_continues_what_is_measured(stand):
    stand.spin_up()
    stand.now += 1.0
    slow = {"base_twist": np.array([0.02, 0.0, 0.0]), "qd": np.zeros(7)}
    last = stand.gate.continue_from(stand.reading(**slow), stand.now)
    assert last.base_twist[0] == 0.02
    stand.send(GOING, **slow)  # what was applied before the gap is no excuse
    assert stand.gate.refusals[Refusal.ACCELERATION] == 1
    assert stand.gate.applied.base_twist[0] < 0.02


def test_after_a_gap_a_late_robot_continues_braking(stand):
    stand.spin_up()
    stand.now += 0.05
    late = {"base_twist": np.array([0.25, 0.0, -0.1]), "qd": np.full(7, 0.5)}
    last = stand.gate.continue_from(stand.reading(**late), stand.now)
    np.testing.assert_allclose(last.base_twist, [0.15, 0.0, -0.1])
    np.testing.assert_allclose(last.qd, 0.3)


def test_motion_between_two_distant_readings_is_not_compared(stand):
    for _ in range(3):
        state = stand.reading()
        assert stand.gate.judge(state, stand.now) is None
        going = command((0.0, 0.0, 0.0), 0.06)
        stand.q = stand.q + 0.4
        stand.now += 0.25
        stand.gate.send(going, state, stand.now)
        stand.now += DT


def test_a_command_that_took_too_long_to_compute_does_not_pass(stand):
    state = stand.reading()
    assert stand.gate.judge(state, 0.0) is None
    assert not stand.gate.send(command((0.01, 0.0, 0.0)), state, 0.2).base_twist.any()
    assert stand.gate.refusals[Refusal.READING] == 1


def test_an_emergency_stop_is_latched_until_it_is_acknowledged(stand):
    small = command((0.01, 0.0, 0.0))
    stand.send(small, faults=(BUTTON,))
    assert not stand.send(small).base_twist.any()
    assert stand.gate.latched
    assert stand.gate.refusals[Refusal.EMERGENCY_STOP] == 2
    stand.gate.acknowledge()
    assert stand.send(small) is small
    stand.send(small, faults=(BUTTON,))
    stand.gate.acknowledge()  # with the button still pressed
    assert not stand.send(small, faults=(BUTTON,)).base_twist.any()
    assert stand.gate.latched


def test_a_joint_beyond_its_range_may_still_come_back(stand):
    inwards = command(qd=-0.05)
    stand.q = LIMITS.q_max + 0.1
    assert stand.send(inwards) is inwards


def test_implausible_readings_end_the_run_in_half_a_second(stand):
    for _ in range(100):
        stand.send(command())
    begun = stand.now
    error = untrusted(lambda _: stand.send(command(), stamp=begun - 1.0))
    assert re.fullmatch(r"the last reading is 1.5\d s old, for 0.5 s", str(error))
    assert stand.now - begun == pytest.approx(0.5, abs=0.03)


def test_a_joint_that_jumped_is_not_believed_however_long_it_stays_there(stand):
    stand.send(command())
    stand.q = READY + np.eye(7)[3]
    error = untrusted(lambda _: stand.send(command()))
    assert "the arm tells q[joint 4] = " in str(error)
    assert "it has jumped" in str(error)
    assert stand.now == pytest.approx(0.5, abs=0.03)


def test_where_a_joint_is_after_a_fault_is_believed(stand):
    stand.send(command(), faults=(REFLEX,))
    stand.q = READY + np.eye(7)[3]
    small = command((0.01, 0.0, 0.0))
    assert stand.send(small) is small


def test_a_part_whose_readings_are_old_is_named(stand):
    late = {"stamp": -1.0, "stamps": PartStamps(0.0, -1.0, 0.0)}
    error = untrusted(lambda _: stand.send(command(), **late))
    assert str(error).startswith("the last reading of the base is 1.5")


@pytest.mark.parametrize("what", ["base", "arm"])
def test_a_frozen_robot_with_fresh_stamps_is_detected(what):
    stand = Stand()

    def go(k: int) -> None:
        speed = min(0.015 * (k + 1), 0.5)
        stand.send(command((speed, 0, 0)) if what == "base" else command(qd=-speed))
        if k > 20:
            stand.wTb, stand.q = SE3.Identity(), READY.copy()

    assert "does not do what it is commanded" in str(untrusted(go))
    assert stand.now < 1.2
    with pytest.raises(UntrustedRobotError):  # and it stays so
        stand.send(command())


@pytest.mark.parametrize("what", ["base", "joint 3"])
def test_motion_that_was_not_commanded_is_detected(what):
    stand = Stand()

    def push(_: int) -> None:
        stand.send(command())
        stand.wTb = stand.wTb * SE3(np.eye(3), np.array([0.01 * (what == "base"), 0.0, 0.0]))
        stand.q = stand.q + 0.01 * (np.arange(7) == 2) * (what != "base")

    assert f"{what} moves as it was not commanded" in str(untrusted(push))


def test_a_base_that_is_relocalised_is_no_reason_to_stop(stand):
    stand.spin_up()
    stand.wTb = SE3(pin.utils.rotate("z", 0.3), np.array([1.0, -2.0, 0.0]))
    for _ in range(100):
        assert stand.send(GOING) is GOING or stand.gate.refusals[Refusal.POSITION]


def test_an_applied_command_that_is_not_finite_is_an_error(stand):
    stand.wire.send = lambda _: command((np.nan, 0, 0))
    with pytest.raises(UntrustedRobotError, match="no finite velocities"):
        stand.send(command())
    assert stand.gate.applied.is_finite()
