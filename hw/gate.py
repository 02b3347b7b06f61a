"""The last check before hardware: only finite commands within limits pass, everything else brakes.

The gate trusts nobody, not even the controller: it compares every command with the limits and with
what the robot applied before. It never scales or repairs a command. One that does not fit is
refused, and the robot brakes for that period.
"""

from __future__ import annotations

from enum import Enum

import numpy as np

from controller import Command
from hw.robot import Robot
from hw.state import FaultKind, RobotState
from robots import Limits

_TOLERANCE = 1e-6
"""Relative slack of every comparison, for rounding only."""


class Refusal(Enum):
    """Why a command did not pass."""

    NOT_FINITE = "not finite"
    SPEED = "above a speed limit"
    ACCELERATION = "above an acceleration limit"
    POSITION = "out of a joint's range"
    FAULT = "the robot has a fault"
    STALE_STATE = "the last reading is too old"
    EMERGENCY_STOP = "emergency stop, not yet released"


class Gate:
    """Stands between the session and one robot.

    Args:
        robot: who gets the commands that pass.
        limits: what must hold.
        period: control period [s].
        oldest_state: refuse to move on a reading older than this [s].
    """

    def __init__(
        self, robot: Robot, limits: Limits, period: float, oldest_state: float = 0.1
    ) -> None:
        self._robot = robot
        self._limits = limits
        self._period = period
        self._oldest_state = oldest_state
        self._latched = False
        self.applied = Command.stop()
        """What the robot really applied last."""
        self.refusals: dict[Refusal, int] = dict.fromkeys(Refusal, 0)
        """How often each reason stopped a command."""

    def send(self, command: Command, state: RobotState, now: float) -> Command:
        """Pass a command on, or brake instead; returns what the robot applied.

        Args:
            command: for the next period.
            state: the reading that the command was computed from.
            now: the session's time [s].
        """
        refusal = self._refusal(command, state, now)
        if refusal is not None:
            self.refusals[refusal] += 1
            command = self._brake()
        self.applied = self._robot.send(command)
        return self.applied

    def release(self) -> None:
        """Allow motion again after an emergency stop, once the button itself is released."""
        self._latched = False

    def _refusal(self, command: Command, state: RobotState, now: float) -> Refusal | None:
        """The first reason not to pass a command, most serious first."""
        if any(fault.kind is FaultKind.EMERGENCY_STOP for fault in state.faults):
            self._latched = True
        if self._latched:
            return Refusal.EMERGENCY_STOP
        if state.faults:
            return Refusal.FAULT
        if not now - state.stamp <= self._oldest_state:
            return Refusal.STALE_STATE
        if not command.is_finite():
            return Refusal.NOT_FINITE
        limits, dt = self._limits, self._period
        base_speed = limits.base_speed(command.base_twist)
        if _exceeds(command.base_twist, base_speed) or _exceeds(command.qd, limits.qd):
            return Refusal.SPEED
        if _exceeds(
            command.base_twist - self.applied.base_twist, limits.base_acceleration * dt
        ) or _exceeds(command.qd - self.applied.qd, limits.qdd * dt):
            return Refusal.ACCELERATION
        q = state.q + command.qd * dt
        outwards = ((q > limits.q_max) & (command.qd > 0.0)) | (
            (q < limits.q_min) & (command.qd < 0.0)
        )
        return Refusal.POSITION if outwards.any() else None

    def _brake(self) -> Command:
        """As near to rest as one period of the acceleration limits allows."""
        limits, dt = self._limits, self._period
        base, qd = self.applied.base_twist, self.applied.qd
        return Command(
            base_twist=base - np.clip(base, *_both_ways(limits.base_acceleration * dt)),
            qd=qd - np.clip(qd, *_both_ways(limits.qdd * dt)),
        )


def _exceeds(values: np.ndarray, limits: np.ndarray) -> bool:
    return bool((np.abs(values) > limits * (1.0 + _TOLERANCE) + 1e-12).any())


def _both_ways(step: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return -step, step
