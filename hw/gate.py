"""The last check before hardware: only sound commands on believable readings pass; the rest brakes.

The gate trusts nobody, not even the controller. It compares every command with the limits, with
what the robot applied before and how long ago that was, and with the way that each joint needs to
stop. It compares every reading with itself, with the one before and with what was commanded. It
never scales or repairs a command: one that does not fit is refused, and the robot brakes.
"""

from __future__ import annotations

from enum import Enum
from math import inf

import numpy as np

from controller import Command
from hw.following import Following
from hw.plausibility import Doubt, Plausibility
from hw.robot import HardwareError, Robot
from hw.state import Array, FaultKind, RobotState
from robots import RobotDescription

_TOLERANCE = 1e-6
"""Relative slack of every comparison, for rounding only."""
_GAP = 3.0
"""After this many periods without a command the robot has begun to stop by itself."""
_SAVED = 2.0
"""Change of velocity that may be saved up, in periods: a tick that comes late by less than one
period does not keep the next from its full acceleration."""
_PATIENCE = 0.5
"""Readings that cannot be believed for longer than this end the run [s]."""


class Refusal(Enum):
    """Why a command did not pass."""

    NOT_FINITE = "not finite"
    SPEED = "above a speed limit"
    ACCELERATION = "above an acceleration limit"
    POSITION = "a joint could not stop within its range"
    FAULT = "the robot has a fault"
    READING = "the reading cannot be believed"
    EMERGENCY_STOP = "emergency stop, not yet acknowledged"


class UntrustedRobotError(HardwareError):
    """The robot does not do what it is commanded, or what it tells cannot be believed."""


class Gate:
    """Stands between the session and one robot.

    `judge` each reading, ask for the velocities that the command has to `continue_from`, `send` the
    command. The change of velocity in any window of time is at most the acceleration limit times
    (the window + 2 periods), unless the gate brakes.

    Args:
        robot: who gets the commands that pass.
        description: of the robot; its limits must hold.
        period: control period [s].
        oldest_state: refuse to move on a reading older than this [s].
    """

    def __init__(
        self, robot: Robot, description: RobotDescription, period: float, oldest_state: float = 0.1
    ) -> None:
        self._robot = robot
        self._limits = description.limits
        self._arm_lag = description.arm.lag
        self._period = period
        self._plausibility = Plausibility(description, oldest_state)
        self._following = Following(description)
        self._refusal: Refusal | None = None
        self._judged: RobotState | None = None
        self._doubted: float | None = None
        self._sent: float | None = None
        self._read = -inf
        self._saved = _SAVED * period
        self._untrusted: UntrustedRobotError | None = None
        self.latched = False
        """Whether an emergency stop has not been acknowledged yet."""
        self.applied = Command.stop()
        """What the robot really applied last."""
        self.doubt: Doubt | None = None
        """Why the last reading could not be believed."""
        self.refusals: dict[Refusal, int] = dict.fromkeys(Refusal, 0)
        """How often each reason stopped a command."""

    def judge(self, state: RobotState, now: float) -> Refusal | None:
        """Whether a reading allows motion; the reason why not, most serious first.

        Args:
            state: the newest reading.
            now: the session's time [s].

        Raises:
            UntrustedRobotError: the readings could not be believed for too long, or the robot does
                not move as it is commanded.
        """
        if self._untrusted is not None:
            raise self._untrusted
        if state is not self._judged:
            try:
                self._judged, self._refusal = state, self._judgement(state, now)
            except UntrustedRobotError as error:
                self._untrusted = error
                raise
        return self._refusal

    def continue_from(self, state: RobotState, now: float) -> Command:
        """The velocities that the coming command has to continue (see `controller.step`).

        They are those applied last; after a gap in the commands those measured. What was applied
        and not reached yet, because the robot follows late, is no reason to take braking back.
        """
        if self._is_after_gap(now):
            last = self.applied
            self.applied = Command(
                base_twist=_braked(last.base_twist, state.base_twist),
                qd=_braked(last.qd, state.qd),
            )
        return self.applied

    def send(self, command: Command, state: RobotState, now: float) -> Command:
        """Pass a command on, or brake instead; returns what the robot applied.

        Args:
            command: for the next period.
            state: the reading that the command was computed from.
            now: the session's time [s].

        Raises:
            UntrustedRobotError: as for `judge`; or what the robot applied is not finite.
        """
        refusal = self.judge(state, now)
        if refusal is Refusal.READING or not self._plausibility.is_fresh(state, now):
            refusal = Refusal.READING
            self.refusals[refusal] += 1
            return self.brake(None, now)
        self.continue_from(state, now)
        refusal = refusal or self._objection(command, state, now)
        if refusal is None:
            return self._apply(command, now)
        self.refusals[refusal] += 1
        return self._brake(now)

    def brake(self, state: RobotState | None, now: float) -> Command:
        """Take velocity away at the emergency deceleration; returns what the robot applied.

        Args:
            state: the newest reading; None where there is none. After a gap in the commands the
                robot has been told to stop anyway, and is told so again.
            now: the session's time [s].

        Raises:
            UntrustedRobotError: what the robot applied is not finite.
        """
        if state is not None and self._plausibility.doubt(state, now) is None:
            self.continue_from(state, now)
        elif self._is_after_gap(now):
            self.applied = Command.stop()
        return self._brake(now)

    def _brake(self, now: float) -> Command:
        limits, dt = self._limits, self._counted(now)
        base, qd = self.applied.base_twist, self.applied.qd
        return self._apply(
            Command(
                base_twist=base - np.clip(base, *_both_ways(limits.base_emergency * dt)),
                qd=qd - np.clip(qd, *_both_ways(limits.qdd * dt)),
            ),
            now,
        )

    def acknowledge(self) -> None:
        """Allow motion again after an emergency stop, once the button itself is released."""
        self.latched = False

    def _judgement(self, state: RobotState, now: float) -> Refusal | None:
        if any(fault.kind is FaultKind.EMERGENCY_STOP for fault in state.faults):
            self.latched = True
        self.doubt = self._plausibility.doubt(state, now)
        if self.doubt is not None:
            self._following.forget()
            self._doubted = now if self._doubted is None else self._doubted
            if now - self._doubted > _PATIENCE:
                raise UntrustedRobotError(f"{self.doubt.value}, for {_PATIENCE:g} s")
            return Refusal.READING
        self._doubted = None
        before, self._read = self._read, state.stamp
        is_after_gap = state.stamp - before > _GAP * self._period or self._is_after_gap(now)
        if self.latched or state.faults or is_after_gap:
            self._following.forget()
        elif mismatch := self._following.mismatch(state, self.applied):
            raise UntrustedRobotError(mismatch)
        if self.latched:
            return Refusal.EMERGENCY_STOP
        return Refusal.FAULT if state.faults else None

    def _objection(self, command: Command, state: RobotState, now: float) -> Refusal | None:
        """What is wrong with a command on a reading that allows motion."""
        limits = self._limits
        is_complete = np.shape(command.base_twist) == (3,) and np.shape(command.qd) == (7,)
        if not (is_complete and command.is_finite()):
            return Refusal.NOT_FINITE
        base_speed = limits.base_speed(command.base_twist)
        if _exceeds(command.base_twist, base_speed) or _exceeds(command.qd, limits.qd):
            return Refusal.SPEED
        if self._spent(command) > self._may_spend(now) * (1.0 + _TOLERANCE) + 1e-12:
            return Refusal.ACCELERATION
        return None if self._can_stop(command.qd, state, now) else Refusal.POSITION

    def _spent(self, command: Command) -> float:
        """Least time in which the acceleration limits allow the change to a command [s]."""
        limits, applied = self._limits, self.applied
        base = np.abs(command.base_twist - applied.base_twist) / limits.base_acceleration
        arm = np.abs(command.qd - applied.qd) / limits.qdd
        return float(max(base.max(), arm.max()))

    def _may_spend(self, now: float) -> float:
        """Time that counts for a change of velocity: elapsed, and saved up before [s]."""
        return min(self._saved + self._counted(now), _SAVED * self._period)

    def _can_stop(self, qd: Array, state: RobotState, now: float) -> bool:
        """Whether every joint that moves outwards can still stop within its range.

        After one period at qd it brakes at qdd. Joints that follow with a lag come to rest one lag
        times their present velocity farther. Since a reading of some age the velocity may have
        grown at qdd.
        """
        limits, lag = self._limits, self._arm_lag
        age = max(0.0, now - state.stamp)
        coasts = state.qd * (age + lag) + np.sign(qd) * limits.qdd * age * (age / 2.0 + lag)
        rest = state.q + coasts + qd * self._period + qd * np.abs(qd) / (2.0 * limits.qdd)
        outwards = ((rest > limits.q_max) & (qd > 0.0)) | ((rest < limits.q_min) & (qd < 0.0))
        return not outwards.any()

    def _elapsed(self, now: float) -> float:
        """Since the last command; one period before the first [s]."""
        return self._period if self._sent is None else now - self._sent

    def _counted(self, now: float) -> float:
        """Time that counts for a change of velocity: after a gap one period [s]."""
        return self._period if self._is_after_gap(now) else self._elapsed(now)

    def _is_after_gap(self, now: float) -> bool:
        """Whether it is not known what the robot did since the last command."""
        return not 0.0 <= self._elapsed(now) <= _GAP * self._period

    def _apply(self, command: Command, now: float) -> Command:
        self._saved = max(0.0, self._may_spend(now) - self._spent(command))
        applied = self._robot.send(command)
        is_complete = np.shape(applied.base_twist) == (3,) and np.shape(applied.qd) == (7,)
        if not (is_complete and applied.is_finite()):
            raise UntrustedRobotError("the robot tells no finite velocities for what it applied")
        self.applied, self._sent = applied, now
        return applied


def _braked(applied: Array, measured: Array) -> Array:
    """The measured velocities, or those applied where they are slower in the same direction."""
    slower = (applied * measured > 0.0) & (np.abs(applied) < np.abs(measured))
    return np.where(slower, applied, measured)


def _exceeds(values: Array, limits: Array) -> bool:
    return bool((np.abs(values) > limits * (1.0 + _TOLERANCE) + 1e-12).any())


def _both_ways(step: Array) -> tuple[Array, Array]:
    return -step, step
