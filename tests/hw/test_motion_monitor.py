"""Motion monitor: a base or joint that is faster than commanded stops the run."""

import re
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from gate_stand import DT, FRANKIE, LIMITS, Stand, command, untrusted
from pinocchio import SE3

from controller import Command
from robots import at_pace

FASTER = [
    ((0.05, 0.0, 0.0), (0.53, 0.0, 0.0), "base drives at 0.53 m/s and was told 0.05 m/s: its own"),
    (
        (0.0, 0.0, 0.3),
        (0.0, 0.0, -0.3),
        "base turns at -0.30 rad/s and was told 0.30 rad/s: the dir",
    ),
    ((0.0, 0.0, 0.0), (-0.15, 0.0, 0.0), "base drives at -0.15 m/s and was told 0.00 m/s: its own"),
]


@pytest.mark.parametrize(("told", "does", "says"), FASTER)
def test_a_base_faster_than_commanded_is_stopped(told, does, says):
    stand = Stand(at_pace(FRANKIE, 0.3))

    def go(k: int) -> None:
        fast = min(1.0, k / 20.0)
        stand.send(command(fast * np.array(told)), base_twist=fast * np.array(does))

    assert says in str(untrusted(go))
    assert stand.now < 0.8


def test_a_joint_faster_than_commanded_is_stopped():
    stand = Stand()
    joint = np.eye(7)[2]

    def go(k: int) -> None:
        told = 0.01 * min(k, 10)
        stand.send(command(qd=told), qd=told + min(0.4, 0.04 * k) * joint)

    assert "joint 3 turns at 0.50 rad/s and was told 0.10 rad/s: its limits" in str(untrusted(go))


def test_a_late_and_noisy_base_is_not_faster_than_commanded():
    """Dead time 0.1 s, lag 0.15 s, noise; commands to brake and to reverse."""
    stand = Stand(replace(FRANKIE, base=replace(FRANKIE.base, lag=0.25)))
    rng, step = np.random.default_rng(1), LIMITS.base_acceleration * DT
    told, twist, late = np.zeros(3), np.zeros(3), [np.zeros(3)] * 10
    for k in range(1500):
        wish = np.array([0.5, 0.0, 0.9]) * np.sign(np.sin(k / 25.0)) * (k % 700 < 600)
        wish[0] *= 0.3 if wish[0] < 0.0 else 1.0
        told = told + np.clip(wish - told, -step, step)
        late = [*late[1:], stand.gate.applied.base_twist]
        twist = twist + DT / 0.15 * (late[0] - twist)
        noise = np.array([0.05, 0.0, 0.1]) * rng.normal(size=3)
        reading = stand.reading(base_twist=twist + noise)
        stand.gate.send(Command(base_twist=told, qd=np.zeros(7)), reading, stand.now)
        vx, vy, w = twist * DT
        stand.oTb = stand.oTb * pin.exp6(np.array([vx, vy, 0.0, 0.0, 0.0, w]))
        stand.now += DT
    assert not any(stand.gate.refusals.values())


def test_an_arm_that_turns_back_late_does_what_it_is_commanded():
    stand = Stand(replace(FRANKIE, arm=replace(FRANKIE.arm, lag=0.18)))
    late = [np.zeros(7)] * 18
    for k in range(500):
        told = 0.9 * np.sin(k / 25.0) * np.eye(7)[6]
        late = [*late[1:], stand.gate.applied.qd]
        stand.gate.send(command(qd=told), stand.reading(qd=late[0]), stand.now)
        stand.q, stand.now = stand.q + late[0] * DT, stand.now + DT
    assert not any(stand.gate.refusals.values())


@pytest.mark.parametrize(
    ("told", "does", "says"),
    [
        (-0.8, -0.27, r"joint 7 does not do what it is commanded: told -0\.[67].*moved at -0\.2"),
        (0.8, 0.01, r"joint 7 does not do what it is commanded: told 0\.\d+ rad/s.*moved at 0\.0"),
        (0.15, -0.25, r"joint 7 moves as it was not commanded: told 0\.[01].*moved at -0\.2"),
    ],
)
def test_a_joint_that_lags_is_told_from_one_that_moves_by_itself(told, does, says):
    stand, last = Stand(), np.eye(7)[6]

    def go(k: int) -> None:
        share, q = min(1.0, k / 20.0), stand.q
        stand.send(Command(base_twist=np.zeros(3), qd=share * told * last), qd=share * does * last)
        stand.q = q + share * does * DT * last

    assert re.search(says, str(untrusted(go)))


def test_a_base_that_lags_is_told_with_figures():
    stand = Stand()

    def go(k: int) -> None:
        oTb = stand.oTb
        stand.send(command((min(0.5, 0.015 * k), 0.0, 0.0)))
        stand.oTb = oTb * SE3(np.eye(3), np.array([0.0005, 0.0, 0.0]))

    told = str(untrusted(go))
    assert re.search(
        r"base does not do what it is commanded: told \(0\.\d.*moved at \(0\.05, 0.00\) m/s", told
    )
