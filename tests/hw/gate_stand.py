"""Test stand of the gate: a robot that follows immediately."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from pinocchio import SE3

from controller import Command
from hw import Gate, RobotState, UntrustedRobotError
from robots import load_robot

FRANKIE = load_robot("frankie")
READY = FRANKIE.arm.ready
LIMITS = FRANKIE.limits
DT = 0.01


class Wire:
    def __init__(self) -> None:
        self.sent: list[Command] = []

    def send(self, command: Command) -> Command:
        self.sent.append(command)
        return command


class Stand:
    """A gate and a robot that follows immediately, one period after the other."""

    def __init__(self, description=FRANKIE) -> None:
        self.wire = Wire()
        self.gate = Gate(self.wire, description, DT)
        self.now = 0.0
        self.oTb = SE3.Identity()
        self.q = READY.copy()

    def reading(self, **changes) -> RobotState:
        applied = self.gate.applied
        usual = RobotState(
            stamp=self.now,
            oTb=self.oTb,
            base_twist=applied.base_twist,
            q=self.q,
            qd=applied.qd,
            gripper_width=0.08,
            gripper_moving=False,
        )
        return replace(usual, **changes)

    def send(self, command: Command, **changes) -> Command:
        """One period."""
        applied = self.gate.send(command, self.reading(**changes), self.now)
        vx, vy, w = applied.base_twist * DT
        self.oTb = self.oTb * pin.exp6(np.array([vx, vy, 0.0, 0.0, 0.0, w]))
        self.q = self.q + applied.qd * DT
        self.now += DT
        return applied

    def spin_up(self) -> None:
        """Bring the robot to 0.15 m/s and 0.3 rad/s in ten valid steps."""
        for k in range(1, 11):
            self.send(command((0.015 * k, 0.0, 0.0), 0.03 * k))
        assert self.gate.applied.base_twist[0] == pytest.approx(0.15)


def command(base=(0.0, 0.0, 0.0), qd=0.0) -> Command:
    return Command(base_twist=np.array(base, dtype=float), qd=np.zeros(7) + qd)


def untrusted(act) -> UntrustedRobotError:
    """The error of the gate within two seconds of an action."""
    for k in range(200):
        try:
            act(k)
        except UntrustedRobotError as error:
            return error
    raise AssertionError("no error")
