"""Injected faults of readings, commands and gripper."""

from dataclasses import replace

import numpy as np
import pytest
from faulty_robot import DT, Faulty, turning
from harness import driving, open_floor

from hw import FaultKind, Gate, HardwareError, LocalisedPose, UntrustedRobotError


def test_a_frozen_state_has_fresh_stamps_and_frozen_stamps_have_fresh_values():
    run = Faulty()
    run.robot.inject("state frozen")
    first = run.read()
    later = run.read(0.5, turning(0.1))
    assert (later.q == first.q).all()
    assert later.stamp == pytest.approx(0.5)
    assert np.abs(run.true().q - first.q).max() > 0.02
    run.robot.clear("state frozen")
    assert (run.read(DT).q == run.true().q).all()
    run.robot.inject("stamps frozen")
    first = run.read()
    later = run.read(0.5, turning(0.1))
    assert later.stamp == first.stamp
    assert np.abs(later.q - first.q).max() > 0.02


def test_late_readings_are_those_of_50_ms_ago_with_their_own_stamps():
    run = Faulty()
    states = {}
    for _ in range(30):
        state = run.read(DT, turning(0.1))
        states[round(state.stamp, 3)] = state.q
    run.robot.inject("readings late")
    for _ in range(20):
        late = run.read(DT, turning(0.1))
        states[round(run.now, 3)] = run.true().q
    assert late.stamp == pytest.approx(run.now - 0.05)
    assert (late.q == states[round(late.stamp, 3)]).all()


def test_readings_are_nan_or_raise():
    run = Faulty()
    run.robot.inject("state nan")
    assert np.isnan(run.read().q).all()
    run.robot.clear()
    assert np.isfinite(run.read().q).all()
    for name, error in (("reading fails", HardwareError), ("reading breaks", OSError)):
        run.robot.clear()
        run.robot.inject(name)
        with pytest.raises(error, match="injected"):
            run.read()


def test_sending_raises_and_nothing_reaches_the_robot():
    run = Faulty()
    run.robot.inject("sending fails")
    run.read()
    with pytest.raises(HardwareError, match="injected"):
        run.robot.send(turning(0.5))
    run.now += DT
    run.harness.clock.sleep_until(run.now)
    assert np.abs(run.true().qd).max() == 0.0


def test_a_localisation_jump_moves_the_base_and_what_the_camera_sees_alike():
    run = Faulty()
    seen_before = run.robot.camera.latest(1.0)
    true = run.read()
    run.robot.inject("localisation jump")
    told, seen = run.read(), run.robot.camera.latest(1.0)
    assert np.linalg.norm(told.oTb.translation - true.oTb.translation) == pytest.approx(0.2)
    turn = true.oTb.rotation.T @ told.oTb.rotation
    assert abs(np.degrees(np.arctan2(turn[1, 0], turn[0, 0]))) == pytest.approx(15.0)
    bTc_before = true.oTb.inverse() * seen_before.oTc
    assert (told.oTb.inverse() * seen.oTc).isApprox(bTc_before, 1e-9)
    run.robot.clear()
    assert run.read().oTb.isApprox(true.oTb)


def test_with_odometry_a_localisation_jump_moves_only_what_is_localised():
    run = Faulty()
    inner, covariance = run.inner.read, np.eye(3)
    told = {}

    def read():
        state = inner()
        tenth = int(10.0 * state.stamp)
        here = LocalisedPose(stamp=state.stamp, mTb=state.oTb, covariance=covariance)
        return replace(state, localised=told.setdefault(tenth, here))

    run.inner.read = read
    true, seen = run.read(), run.robot.camera.latest(1.0)
    run.robot.inject("localisation jump")
    wrong = run.read()
    assert wrong.oTb == true.oTb
    assert run.robot.camera.latest(1.0).oTc == seen.oTc
    off = wrong.localised.mTb.translation - true.oTb.translation
    assert np.linalg.norm(off) == pytest.approx(0.2)
    assert run.read().localised is wrong.localised
    assert run.read(0.2).localised is not wrong.localised


def test_localisation_drifts_with_the_distance():
    run = Faulty(world=open_floor())
    run.robot.inject("localisation drift")
    run.read()
    told = run.read(3.0, driving(0.5)).oTb.translation[0]
    true = run.true().oTb.translation[0]
    assert true > 1.0
    assert told == pytest.approx(1.03 * true)


def test_a_base_that_ignores_commands_rolls_out_within_its_limits_and_claims_to_obey():
    run = Faulty()
    run.read(2.0, driving(0.5))
    run.robot.inject("base ignores commands")
    run.read()
    speeds = [float(run.true().base_twist[0])]
    for _ in range(200):
        assert run.robot.send(driving(0.5)).base_twist[0] == 0.5
        run.read(DT)
        speeds.append(float(run.true().base_twist[0]))
    limit = run.robot.description.limits.base_acceleration[0]
    assert np.abs(np.diff(speeds)).max() <= limit * DT * 1.01
    assert speeds[-1] == pytest.approx(0.0, abs=1e-3)


def test_a_base_that_is_too_fast_claims_to_obey_and_the_gate_finds_out():
    run = Faulty(world=open_floor())
    gate = Gate(run.robot, run.robot.description, DT)
    run.robot.inject("base too fast")

    def drive() -> None:
        for k in range(200):
            gate.send(driving(min(0.1, 0.01 * k)), run.read(DT), run.now)

    with pytest.raises(UntrustedRobotError, match=r"drives at .* m/s and was told 0.10 m/s: its"):
        drive()
    assert run.true().oTb.translation[0] < 0.1


def test_a_bumper_comes_back_three_times_after_a_recovery():
    run = Faulty()
    run.robot.inject("bumper again")
    for _ in range(4):
        assert [fault.kind for fault in run.read().faults] == [FaultKind.BUMPER]
        run.robot.recover()
        assert not run.read(0.2).faults
        run.read(0.2)
    assert not run.read().faults


@pytest.mark.parametrize(("name", "width"), [("gripper dead", 0.08), ("gripper halfway", 0.04)])
def test_fingers_that_do_not_move_as_they_are_told(name, width):
    run = Faulty()
    run.robot.inject(name)
    run.read()
    run.robot.grip(0.0, 20.0)
    state = run.read(3.0)
    assert state.gripper_width == pytest.approx(width)
    assert not state.gripper_moving
