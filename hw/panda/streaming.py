"""What happens 1000 times a second: where the arm is, what is wanted, what it is commanded."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from hw.clock import stopwatch
from hw.panda.generation import JointLimits
from hw.panda.limiter import PERIOD, VelocityLimiter, speed_at
from hw.panda.records import ArmReading, Mode
from hw.processes.child import still_alive
from hw.processes.mailbox import Mailbox

FRESH = 0.06
"""A velocity command counts for this long; then the arm comes to rest [s]."""
_IDLE = 0.5
"""An arm that rests for so long without a command leaves the motion [s]."""
_RESTS = 1e-5
"""[rad/s]"""
_ZERO = (0.0,) * 7
_SOFT = 1.5
"""Acceleration on the way to a goal [rad/s^2]."""
_ARRIVED = 2e-3
"""[rad]"""

Publish = Callable[[Any, Sequence[float]], None]


class Streaming:
    """One motion: velocity commands become a stream that the arm accepts, until they end.

    Args:
        limits: of the arm.
        commands: the newest command.
        publish: tells (state, velocities commanded next).
        over: whether nobody is left to command.
        velocities: makes the vendor's command of seven velocities [rad/s].
        goal: (7,) where to go instead of following commands [rad]; any newer command ends it.
        speed: of the fastest joint on the way to it [rad/s].
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
        self.lost = 0
        """Milliseconds of the arm's clock in which no state was seen."""
        self.arrived = False
        """Whether the goal is reached."""

    def __call__(self, state: Any, period: Any) -> Any:
        """The velocities for the next millisecond, from the state of this one."""
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
        """Velocities to come to; None if there is nobody who wants any."""
        command = self._commands.get()
        if self._over() or command is None:
            return None
        if self._goal is not None:
            stopped = command[0] != self._before
            return None if stopped or self.arrived else self._towards(self._goal, q)
        return command[2:] if now - command[1] <= FRESH else None

    def _towards(self, goal: Sequence[float], q: Sequence[float]) -> Sequence[float]:
        """All joints arrive at the same time, none faster than allowed."""
        way = [g - p for g, p in zip(goal, q, strict=True)]
        farthest = max(map(abs, way))
        self.arrived = farthest < _ARRIVED
        self._ramp += _SOFT * PERIOD
        speed = min(self._speed, self._ramp, speed_at(farthest, _SOFT))
        return [speed * one / farthest for one in way] if farthest > 0.0 else _ZERO


def _rest(qd: Sequence[float]) -> bool:
    return max(map(abs, qd)) < _RESTS


def reading_of(state: Any, *, commanded: Sequence[float], lost: int, trouble: str) -> ArmReading:
    """A state of the vendor's library as a record, stamped now."""
    return ArmReading(
        stamp=stopwatch(),
        time=state.time.to_msec(),
        mode=Mode(int(state.robot_mode)),
        q=tuple(state.q),
        qd=tuple(state.dq),
        commanded=tuple(commanded),
        lost=lost,
        success_rate=state.control_command_success_rate,
        hand_mass=state.m_ee,
        load=state.m_load,
        trouble=trouble,
    )
