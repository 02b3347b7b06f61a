"""Command gate: checks every command and reading, scales none, and brakes on a refusal."""

from enum import Enum
from math import copysign, inf

import numpy as np

from controller import Command
from hw.motion_monitor import MotionMonitor
from hw.plausible_readings import Plausibility
from hw.robot import HardwareError, Robot
from hw.state import Array, FaultKind, RobotState
from robots import RobotDescription

_TOLERANCE = 1e-6  # relative, of every comparison: rounding only
_MAX_GAP = 3.0  # periods without a command after which the robot stops by itself
_CREDIT = 2.0  # periods of unused time that count, so a late tick keeps its full acceleration
_TIMEOUT = 0.5  # implausible readings for longer than this end the run [s]


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
    """The robot does not move as commanded, or its readings stay implausible."""


class Gate:
    """Checks the commands to one robot: `judge` each reading, then `send` the command.

    The change of velocity in any window of time is at most the acceleration limit times (the
    window + 2 periods), unless the gate brakes. A stale reading allows no motion.
    """

    def __init__(self, robot: Robot, description: RobotDescription, period: float) -> None:
        self._robot = robot
        self._limits = description.limits
        self._arm_lag = description.arm.lag
        self._arm = description.arm.ready.shape
        self._period = period
        self._plausibility = Plausibility(description)
        self._monitor = MotionMonitor(description)
        self._refusal: Refusal | None = None
        self._judged: RobotState | None = None
        self._implausible_since: float | None = None
        self._sent: float | None = None
        self._read = -inf
        self._credit = inf  # as much as counts
        self._untrusted: UntrustedRobotError | None = None
        self.latched = False  # an emergency stop is not acknowledged yet
        self.applied = Command.stop(*self._arm)  # by the robot, last
        self.refusals: dict[Refusal, int] = dict.fromkeys(Refusal, 0)  # commands stopped

    def judge(self, state: RobotState, now: float) -> Refusal | None:
        """Why a reading forbids motion; None if it does not. UntrustedRobotError: for too long."""
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
        """The velocities that the coming command continues: applied last, after a gap measured."""
        if self._is_after_gap(now):
            last = self.applied
            self.applied = Command(
                base_twist=_braked(last.base_twist, state.base_twist), qd=_braked(last.qd, state.qd)
            )
        return self.applied

    def send(self, command: Command, state: RobotState, now: float) -> Command:
        """Pass a command on, or brake instead; what the robot applied. Raises as `judge`."""
        refusal = self.judge(state, now)
        if refusal is Refusal.READING or not self._plausibility.is_fresh(state, now):
            refusal = Refusal.READING
            self.refusals[refusal] += 1
            return self.brake(None, now)
        self.continue_from(state, now)
        refusal = refusal or self._violation(command, state, now)
        if refusal is None:
            return self._apply(command, now)
        self.refusals[refusal] += 1
        return self._brake(now)

    def brake(self, state: RobotState | None, now: float) -> Command:
        """Reduce the velocity at the emergency deceleration; returns what the robot applied."""
        if state is not None and not self._plausibility.doubt(state, now):
            self.continue_from(state, now)
        elif self._is_after_gap(now):
            self.applied = Command.stop(*self._arm)
        return self._brake(now)

    def _brake(self, now: float) -> Command:
        limits, dt = self._limits, self._dt(now)
        base, qd = self.applied.base_twist, self.applied.qd
        slower, slower_qd = limits.base_emergency * dt, limits.qdd * dt
        base, qd = base - np.clip(base, -slower, slower), qd - np.clip(qd, -slower_qd, slower_qd)
        return self._apply(Command(base_twist=base, qd=qd), now)

    def acknowledge(self) -> None:
        """Allow motion again after an emergency stop, once the button itself is released."""
        self.latched = False

    def _judgement(self, state: RobotState, now: float) -> Refusal | None:
        if any(fault.kind is FaultKind.EMERGENCY_STOP for fault in state.faults):
            self.latched = True
        doubt = self._plausibility.doubt(state, now)
        if doubt:
            self._monitor.reset()
            since = self._implausible_since
            self._implausible_since = since = now if since is None else since
            if now - since > _TIMEOUT:
                raise UntrustedRobotError(f"{doubt}, for {_TIMEOUT:g} s")
            return Refusal.READING
        self._implausible_since = None
        before, self._read = self._read, state.stamp
        is_after_gap = state.stamp - before > _MAX_GAP * self._period or self._is_after_gap(now)
        if self.latched or state.faults or is_after_gap:
            self._monitor.reset()
        elif mismatch := self._monitor.mismatch(state, self.applied):
            raise UntrustedRobotError(mismatch)
        if self.latched:
            return Refusal.EMERGENCY_STOP
        return Refusal.FAULT if state.faults else None

    def _violation(self, command: Command, state: RobotState, now: float) -> Refusal | None:
        """Which limit a command breaks on a reading that allows motion."""
        limits = self._limits
        is_complete = np.shape(command.base_twist) == (3,) and np.shape(command.qd) == self._arm
        if not (is_complete and command.is_finite()):
            return Refusal.NOT_FINITE
        speeds = *command.base_twist.tolist(), *command.qd.tolist()
        allowed = *limits.base_speed(command.base_twist).tolist(), *limits.qd.tolist()
        if any(map(_exceeds, speeds, allowed)):
            return Refusal.SPEED
        if _exceeds(self._needed(command), self._available(now)):
            return Refusal.ACCELERATION
        return None if self._can_stop(command.qd, state, now) else Refusal.POSITION

    def _needed(self, command: Command) -> float:
        """Least time in which the acceleration limits allow the change to a command [s]."""
        limits, applied = self._limits, self.applied
        base = np.abs(command.base_twist - applied.base_twist) / limits.base_acceleration
        arm = np.abs(command.qd - applied.qd) / limits.qdd
        return float(max(*base.tolist(), *arm.tolist()))

    def _available(self, now: float) -> float:
        """Time available for a change of velocity: elapsed, and credit from before [s]."""
        return min(self._credit + self._dt(now), _CREDIT * self._period)

    def _can_stop(self, qd: Array, state: RobotState, now: float) -> bool:
        """Whether every joint that moves outwards can still stop within its range.

        After one period at qd it brakes at qdd. A joint with lag coasts one lag times its velocity
        farther. Since a reading of some age the velocity may have grown at qdd.
        """
        limits, lag, age = self._limits, self._arm_lag, max(0.0, now - state.stamp)
        arrays = state.q, state.qd, qd, limits.qdd, limits.q_min, limits.q_max
        for q, moves, told, most, low, high in zip(*(one.tolist() for one in arrays), strict=True):
            coasts = moves * (age + lag) + copysign(most * age * (age / 2.0 + lag), told)
            rest = q + coasts + told * self._period + told * abs(told) / (2.0 * most)
            if (told > 0.0 and rest > high) or (told < 0.0 and rest < low):
                return False
        return True

    def _elapsed(self, now: float) -> float:
        """Since the last command; one period before the first [s]."""
        return self._period if self._sent is None else now - self._sent

    def _dt(self, now: float) -> float:
        """Time since the last command; after a gap one period [s]."""
        return self._period if self._is_after_gap(now) else self._elapsed(now)

    def _is_after_gap(self, now: float) -> bool:
        return not 0.0 <= self._elapsed(now) <= _MAX_GAP * self._period

    def _apply(self, command: Command, now: float) -> Command:
        self._credit = max(0.0, self._available(now) - self._needed(command))
        applied = self._robot.send(command)
        is_complete = np.shape(applied.base_twist) == (3,) and np.shape(applied.qd) == self._arm
        if not (is_complete and applied.is_finite()):
            raise UntrustedRobotError("the robot tells no finite velocities for what it applied")
        self.applied, self._sent = applied, now
        return applied


def _braked(applied: Array, measured: Array) -> Array:
    """The measured velocities, or those applied where they are slower in the same direction."""
    slower = (applied * measured > 0.0) & (np.abs(applied) < np.abs(measured))
    return np.where(slower, applied, measured)


def _exceeds(value: float, limit: float) -> bool:
    return abs(value) > limit * (1.0 + _TOLERANCE) + 1e-12
