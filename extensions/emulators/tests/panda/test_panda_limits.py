"""What limits the arm keeps: where joints end, how long a stop takes, and what breaks a limit."""

import numpy as np
import pytest

from drivers.panda import LIMITS, VelocityLimiter
from drivers.panda.arm import Lead
from extensions.emulators.panda import EmulatedArm, LaggedJoints, MotionCommand
from robots import load_robot


def by_velocity(number: int, qd: tuple[float, ...]) -> MotionCommand:
    return MotionCommand(number, qd, False)


@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_joints_that_are_driven_to_their_ends_stop_before_them(way):
    start = list((np.array(LIMITS.q_min) + np.array(LIMITS.q_max)) / 2.0)
    arm = EmulatedArm(LaggedJoints(tuple(map(float, start))), LIMITS)
    arm.begin_motion()
    limiter = VelocityLimiter(LIMITS)
    wanted = np.full(7, way * 100.0)
    for tick in range(2500):
        qd = limiter.step(arm.q_d, arm.qd_d, arm.qdd_d, wanted)
        arm.tick(by_velocity(tick, tuple(qd)))
    assert not arm.errors
    ends = LIMITS.q_max if way > 0.0 else LIMITS.q_min
    assert np.abs(np.subtract(arm.joints.q, ends)).max() < 0.03
    assert np.abs(arm.joints.qd).max() < 1e-3


def broken(arm: EmulatedArm, *commands: tuple[float, ...]) -> str:
    arm.begin_motion()
    for number, qd in enumerate(commands):
        arm.tick(by_velocity(number, qd))
    return next(iter(arm.errors), "")


@pytest.mark.parametrize(
    ("speeds", "error"),
    [
        ([0.01], "joint_motion_generator_velocity_discontinuity"),
        ([0.006], "joint_motion_generator_acceleration_discontinuity"),
        ([0.003, 0.009], ""),
        ([3.0], "joint_motion_generator_velocity_limits_violation"),
        ([float("nan")], "joint_motion_generator_velocity_limits_violation"),
    ],
)
def test_the_emulated_arm_does_refuse_what_the_real_one_refuses(speeds, error):
    arm = EmulatedArm(LaggedJoints(), LIMITS)
    commands = [(0.0, speed, *(0.0,) * 5) for speed in speeds]
    assert broken(arm, *commands) == error


def test_the_emulated_arm_counts_lost_packets_and_stops_at_twenty():
    arm = EmulatedArm(LaggedJoints(), LIMITS)
    arm.begin_motion()
    arm.tick(by_velocity(1, (0.003,) * 7))
    for _ in range(19):
        arm.tick(None)
    assert not arm.errors
    # Meanwhile it goes on with the acceleration that it had.
    assert arm.qd_d[0] == pytest.approx(0.06)
    arm.tick(None)
    assert arm.errors == {"communication_constraints_violation"}
    for _ in range(30):
        arm.tick(None)
    assert not any(arm.qd_d)


def test_the_limits_are_those_of_the_description():
    described = load_robot("frankie").limits
    np.testing.assert_array_equal(LIMITS.q_min, described.q_min)
    np.testing.assert_array_equal(LIMITS.q_max, described.q_max)
    np.testing.assert_array_equal(LIMITS.qd, described.qd)
    assert (VelocityLimiter(LIMITS).qdd >= described.qdd).all()


def led(lead: Lead, *speeds: float) -> list[float]:
    """What joint 1 is commanded, at 100 Hz."""
    return [lead.of(v * np.eye(7)[0], tick * 0.01)[0] for tick, v in enumerate(speeds)]


def test_a_slope_is_led_by_the_lag_and_by_no_more_than_the_arm_can_accelerate():
    qdd = np.array(LIMITS.qdd)
    assert led(Lead(0.0, qdd), 0.1, 0.2, 0.0, -0.3) == [0.1, 0.2, 0.0, -0.3]
    lead = Lead(0.03, qdd)
    assert led(lead, 0.1, 0.12, 0.14, 0.0) == pytest.approx([0.1, 0.18, 0.2, 0.0])
    assert lead.of(0.3 * np.eye(7)[0], 1.0)[0] == 0.3  # after a pause
    assert led(Lead(0.03, qdd), 0.1, 9.0)[1] == pytest.approx(9.0 + 0.03 * qdd[0])
    assert lead.of(0.4 * np.eye(7)[0], 1.0 + 1e-6)[0] == pytest.approx(0.4 + 0.03 * 10.0)
