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
from robots import at_pace


@pytest.fixture
def stand() -> Stand:
    return Stand()


REFLEX = Fault(kind=FaultKind.REFLEX, text="touched something", clearable=True)
BUTTON = Fault(kind=FaultKind.EMERGENCY_STOP, text="button pressed", clearable=False)


def test_a_valid_command_passes_unchanged(stand):
    good = command((0.015, 0.0, 0.03), 0.06)
    assert stand.send(good, localised=localised()) is good
    assert stand.send(good) is good  # where the base is on its map is told from time to time
    assert stand.wire.sent == [good, good]
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
    (GOING, {"oTb": SE3(2.0 * np.eye(3), np.zeros(3))}, Refusal.READING),
    (GOING, {"oTb": SE3(np.eye(3), np.array([np.nan, 0, 0]))}, Refusal.READING),
    (GOING, {"gripper_width": np.nan}, Refusal.READING),
    (GOING, {"battery": np.nan}, Refusal.READING),
    (GOING, {"localised": localised(x=np.nan)}, Refusal.READING),
    (GOING, {"localised": localised(covariance=np.full((3, 3), np.nan))}, Refusal.READING),
    (GOING, {"localised": localised(covariance=-np.eye(3))}, Refusal.READING),
    (GOING, {"localised": localised(covariance=np.eye(2))}, Refusal.READING),
]


TURN = 2e-5 * np.eye(3)
ASKEW = pin.exp3(np.array([0.4, -0.7, 1.1]))
THRESHOLDS = [  # of readings at rest, at 1 s: what is changed, just within and just beyond
    ("stamp", 0.901, 0.899),
    ("stamp", 1.0049, 1.0051),
    ("q", LIMITS.q_max + 0.499, LIMITS.q_max + 0.501),
    ("q", LIMITS.q_min - 0.499, LIMITS.q_min - 0.501),
    ("qd", 1.99 * LIMITS.qd, 2.01 * LIMITS.qd),
    ("base_twist", np.array([0.0, 0.199, 0.0]), np.array([0.0, 0.201, 0.0])),
    ("oTb", SE3(np.eye(3) + TURN * 0.8, np.zeros(3)), SE3(np.eye(3) + TURN * 2.0, np.zeros(3))),
    ("oTb", SE3(ASKEW, np.zeros(3)), SE3(-ASKEW, np.zeros(3))),
    ("battery", 1.0, 1.01),
    ("battery", 0.0, -0.01),
]


@pytest.mark.parametrize(("field", "within", "beyond"), THRESHOLDS)
def test_a_reading_is_believed_up_to_its_threshold(field, within, beyond):
    for value, doubted in ((within, None), (beyond, Refusal.READING)):
        stand = Stand()
        stand.now = 1.0
        assert stand.gate.judge(stand.reading(**{field: value}), 1.0) is doubted


def test_full_speed_is_believed_at_half_of_it():
    stand = Stand(at_pace(FRANKIE, 0.5))
    for speed, doubted in ((1.99, None), (2.01, Refusal.READING)):
        assert stand.gate.judge(stand.reading(qd=speed * LIMITS.qd), 0.0) is doubted


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_joint_has_jumped_where_twice_its_speed_and_noise_do_not_explain_it(way):
    for beyond, doubted in ((-0.001, None), (0.001, Refusal.READING)):
        stand = Stand()
        stand.now = 1.0
        stand.gate.judge(stand.reading(), 1.0)
        stand.now = 1.05  # after a gap, so that the motion itself is not compared
        q = READY + way * (2.0 * LIMITS.qd * 0.05 + 0.05 + beyond) * np.eye(7)[0]
        assert stand.gate.judge(stand.reading(q=q), 1.05) is doubted


@pytest.mark.parametrize("speed", [0.02, -0.02])
def test_a_gap_begins_after_three_periods(speed):
    measured = {"base_twist": np.array([speed, 0.0, 0.0])}
    for gap, continued in ((2.99, 0.015), (3.01, min(speed, 0.015))):
        stand = Stand()
        stand.send(command((0.015, 0.0, 0.0)))
        now = stand.now - DT + gap * DT
        last = stand.gate.continue_from(stand.reading(**measured), now)
        assert last.base_twist[0] == continued


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("age", [0.0, 0.08])
def test_a_joint_may_move_as_long_as_it_can_stop_within_its_range(way, age):
    """It was seen at 0.1 rad/s a while ago and has accelerated since; the command is 0.05 rad/s."""
    lag, qdd = FRANKIE.arm.lag, LIMITS.qdd[0]
    grown = 0.1 + qdd * age
    until_now = (0.1 + grown) / 2.0 * age
    way_to_rest = until_now + grown * lag + 0.05 * DT + 0.05**2 / (2.0 * qdd)
    limit = (LIMITS.q_max if way > 0.0 else LIMITS.q_min)[0]
    for spare, passes in ((1e-5, True), (-1e-5, False)):
        stand = Stand()
        q, moving = READY.copy(), np.zeros(7)
        q[0], moving[0] = limit - way * (way_to_rest + spare), way * 0.1
        wanted = Command(base_twist=np.zeros(3), qd=way * 0.05 * np.eye(7)[0])
        assert (stand.send(wanted, q=q, qd=moving, stamp=-age) is wanted) is passes


@pytest.mark.parametrize("rounding", [0.9e-6, 1.1e-6])
def test_only_rounding_may_exceed_a_limit(rounding):
    limits = replace(LIMITS, qd=np.full(7, 0.06))
    for description, wanted in (
        (replace(FRANKIE, limits=limits), command(qd=0.06 * (1.0 + rounding))),
        (FRANKIE, command(qd=2.0 * LIMITS.qdd[0] * DT * (1.0 + rounding))),
        (FRANKIE, command((0.0, 1e-6 * rounding, 0.0))),  # which is nothing
    ):
        assert (Stand(description).send(wanted) is wanted) is (rounding < 1e-6)


@pytest.mark.parametrize(("age", "continued"), [(0.0, 0.1), (1.0, 0.0)])
def test_braking_after_a_gap_continues_what_is_measured_if_that_is_believed(age, continued):
    stand = Stand()
    stand.spin_up()
    stand.now += 1.0
    measured = {"base_twist": np.array([0.1, 0.0, 0.0]), "qd": np.zeros(7)}
    braked = stand.gate.brake(stand.reading(stamp=stand.now - age, **measured), stand.now)
    expected = max(0.0, continued - LIMITS.base_emergency[0] * DT)
    assert braked.base_twist[0] == pytest.approx(expected)


@pytest.mark.parametrize("faults", [(REFLEX,), (BUTTON,), ()])
def test_who_moves_an_arm_that_stands_still_by_a_fault_is_no_fault(faults):
    stand = Stand()
    stand.send(command(), faults=faults or (BUTTON,))
    for _ in range(40):  # without any, the button is released, but not yet acknowledged
        stand.q = stand.q + 0.01
        stand.send(command(), faults=faults)


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


@pytest.mark.parametrize(("q", "qd"), [(LIMITS.q_max + 0.1, -0.05), (LIMITS.q_min - 0.1, 0.05)])
def test_a_joint_beyond_its_range_may_still_come_back(stand, q, qd):
    inwards, stand.q = command(qd=qd), q
    assert stand.send(inwards) is inwards


def test_implausible_readings_end_the_run_in_half_a_second(stand):
    for _ in range(100):
        stand.send(command())
    begun = stand.now
    error = untrusted(lambda _: stand.send(command(), stamp=begun - 1.0))
    assert re.fullmatch(r"the last reading is 1.5\d s old, for 0.5 s", str(error))
    assert stand.now - begun == pytest.approx(0.5, abs=0.03)


def test_a_joint_that_jumped_is_not_believed_however_long_it_stays_there(stand):
    stand.now = 5.0
    stand.send(command())
    stand.q = READY + np.eye(7)[3]
    error = untrusted(lambda _: stand.send(command()))
    assert "the arm tells q[joint 4] = " in str(error)
    assert "it has jumped" in str(error)
    assert stand.now == pytest.approx(5.5, abs=0.03)


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
            stand.oTb, stand.q = SE3.Identity(), READY.copy()

    assert "does not do what it is commanded" in str(untrusted(go))
    assert stand.now < 1.2
    with pytest.raises(UntrustedRobotError):  # and it stays so
        stand.send(command())


@pytest.mark.parametrize("what", ["base", "joint 3"])
def test_motion_that_was_not_commanded_is_detected(what):
    stand = Stand()

    def push(_: int) -> None:
        stand.send(command())
        stand.oTb = stand.oTb * SE3(np.eye(3), np.array([0.01 * (what == "base"), 0.0, 0.0]))
        stand.q = stand.q + 0.01 * (np.arange(7) == 2) * (what != "base")

    assert f"{what} moves as it was not commanded" in str(untrusted(push))


def test_a_base_that_is_relocalised_is_no_reason_to_stop(stand):
    stand.spin_up()
    stand.oTb = SE3(pin.utils.rotate("z", 0.3), np.array([1.0, -2.0, 0.0]))
    for _ in range(100):
        assert stand.send(GOING) is GOING or stand.gate.refusals[Refusal.POSITION]


BROKEN = [{"base_twist": np.zeros(2)}, {"qd": np.zeros(6)}, {"base_twist": np.full(3, np.nan)}]


@pytest.mark.parametrize("told", BROKEN)
def test_an_applied_command_that_lacks_a_number_is_an_error(stand, told):
    stand.wire.send = lambda one: replace(one, **told)
    with pytest.raises(UntrustedRobotError, match="no finite velocities"):
        stand.send(command())
    assert stand.gate.applied.is_finite()
