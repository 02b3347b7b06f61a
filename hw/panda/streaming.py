"""The 1 kHz loop: velocity commands become a stream that the arm accepts, and are monitored."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from hw.clock import stopwatch
from hw.panda.library import JointLimits
from hw.panda.limiter import PERIOD, VelocityLimiter, speed_at
from hw.processes.child import still_alive
from hw.processes.mailbox import Mailbox

FRESH = 0.06  # a velocity command is valid for this long; then the arm comes to rest [s]
_IDLE = 0.5  # at rest without a command for this long the motion ends [s]
_RESTS = 1e-5  # slower joints are at rest [rad/s]
_ZERO = (0.0,) * 7
_SOFT = 1.5  # acceleration on the way to a goal [rad/s^2]
_ARRIVED = 2e-3  # tolerance of a goal [rad]
_MARGIN, _TOO_FAST = 0.25, 0.2
"""A joint that is faster than commanded by more than this [rad/s] for this long [s] is stopped."""
_DECAY = 0.99
"""Joints follow late: earlier commands are allowed for with this factor in each period."""

Publish = Callable[[Any, Sequence[float]], None]


class Streaming:
    """One motion: the callback of the vendor's control loop.

    Args:
        limits: of the arm.
        commands: with the newest command.
        publish: called with state and next velocities.
        over: whether the parent has ended.
        velocities: makes the vendor's command of seven velocities [rad/s].
        goal: (7,) joint positions to go to instead [rad]; any newer command ends that.
        speed: of the fastest joint on the way to the goal [rad/s].
        now: time of the stamps of commands [s].
    """

    def __init__(
        self,
        limits: JointLimits,
        commands: Mailbox,
        publish: Publish,
        over: Callable[[], bool],
        velocities: Callable[[Sequence[float]], Any],
        goal: Sequence[float] | None = None,
        speed: float = 0.5,
        now: Callable[[], float] = stopwatch,
    ) -> None:
        self._now = now
        self._commands, self._publish = commands, publish
        self._limiter = VelocityLimiter(limits)
        self._over, self._velocities = over, velocities
        self._goal, self._speed = goal, speed
        self._before = (commands.get() or (0,))[0]
        self._asked = now()
        self._ticks = 0
        self._ramp = 0.0
        self.lost = 0  # milliseconds of the arm's clock without a state
        self.arrived = False  # whether the goal is reached

    def __call__(self, state: Any, period: Any) -> Any:
        """The velocities for the next millisecond."""
        now = self._now()
        self._ticks += 1
        if self._ticks % 100 == 1:
            still_alive()
        self.lost += max(0, period.to_msec() - 1)
        q, qd = state.q_d, state.dq_d
        wanted = self._wanted(now, q)
        if wanted is None:
            lingers = self._goal is None and not self._over()
            if now - self._asked > (_IDLE if lingers else 0.0) and _rest(qd):
                command = self._velocities(_ZERO)
                command.motion_finished = True
                return command
            wanted = _ZERO
        else:
            self._asked = now
        following = self._limiter.step(q, qd, state.ddq_d, wanted)
        self._publish(state, following)
        return self._velocities(following)

    def _wanted(self, now: float, q: Sequence[float]) -> Sequence[float] | None:
        """Velocities to reach; None without a valid command."""
        command = self._commands.get()
        if self._over() or command is None:
            return None
        if self._goal is not None:
            stopped = command[0] != self._before
            return None if stopped or self.arrived else self._towards(self._goal, q)
        return command[2:] if now - command[1] <= FRESH else None

    def _towards(self, goal: Sequence[float], q: Sequence[float]) -> Sequence[float]:
        """Velocities with which all joints arrive at the same time."""
        way = [g - p for g, p in zip(goal, q, strict=True)]
        farthest = max(map(abs, way))
        self.arrived = farthest < _ARRIVED
        self._ramp += _SOFT * PERIOD
        speed = min(self._speed, self._ramp, speed_at(farthest, _SOFT))
        return [speed * one / farthest for one in way] if farthest > 0.0 else _ZERO


def _rest(qd: Sequence[float]) -> bool:
    return max(map(abs, qd)) < _RESTS


class SpeedError(Exception):
    """A joint moves faster than commanded."""


class SpeedMonitor:
    """Compares measured with commanded speeds in one motion."""

    def __init__(self) -> None:
        self._commanded: Sequence[float] = _ZERO
        self._fastest: Sequence[float] = _ZERO
        self._since: float | None = None

    def check(self, now: float, measured: Sequence[float], commanded: Sequence[float]) -> None:
        """Once a period.

        Args:
            now: [s].
            measured: (7,) velocities [rad/s].
            commanded: (7,) velocities from now on [rad/s].

        Raises:
            SpeedError: one joint has been too fast for too long.
        """
        before, self._commanded = self._commanded, commanded
        rows = zip(before, self._fastest, strict=True)
        self._fastest = fastest = [max(abs(qd), _DECAY * most) for qd, most in rows]
        beyond = [abs(qd) - most for qd, most in zip(measured, fastest, strict=True)]
        worst = max(beyond)
        if worst <= _MARGIN:
            self._since = None
        elif self._since is None:
            self._since = now
        elif now - self._since > _TOO_FAST:
            joint = beyond.index(worst)
            raise SpeedError(
                f"joint {joint + 1} moved at {measured[joint]:.2f} rad/s and was told "
                f"{before[joint]:.2f} rad/s: something pushes it, or the masses in Desk are wrong; "
                "look, then recover"
            )
