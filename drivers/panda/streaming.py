"""The 1 kHz loop: smooth velocities from what the arm reports as commanded last; monitored."""

from collections.abc import Callable, Sequence
from math import sqrt
from typing import Any

from drivers.panda.library import JointLimits
from drivers.processes.child import still_alive
from drivers.processes.mailbox import Mailbox
from hw.clock import stopwatch

PERIOD = 0.001  # of the control loop [s]
_LOST = 4  # number of packets in a row that may be lost at the highest speed
_EPSILON = 1e-3  # margin to velocity limits [rad/s], as in the vendor's library
_POSITION_MARGIN = 0.01  # margin to position limits [rad]
_ACCELERATION, _JERK = 0.95, 0.25  # shares of the limits that are used
_HARD = 0.98  # share of the jerk for a joint that lost packets accelerate beyond its speed
_GAIN = 20.0  # slope of the speed over the distance close to a limit or a goal [1/s]
FRESH = 0.06  # a velocity command is valid for this long; then the arm comes to rest [s]
_IDLE = 0.5  # at rest without a command for this long the motion ends [s]
_RESTS = 1e-5  # slower joints are at rest [rad/s]
_ZERO = (0.0,) * 7
_SOFT = 1.5  # acceleration on the way to a goal [rad/s^2]
_ARRIVED = 2e-3  # tolerance of a goal [rad]
_MARGIN, _TOO_FAST = 0.25, 0.2  # a joint faster by this [rad/s] for this [s] is stopped
_DECAY = 0.99  # per period, of earlier commands, as joints follow late

Publish = Callable[[Any, Sequence[float]], None]


class Streaming:
    """One motion, the vendor's callback: by commands, or to a `goal` (7,) [rad] until a command."""

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
            rests = max(map(abs, qd)) < _RESTS
            if rests and now - self._asked > (_IDLE if lingers else 0.0):
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


class VelocityLimiter:
    """Brings the commanded velocities of the joints to the wanted ones."""

    def __init__(self, limits: JointLimits) -> None:
        self.qdd = tuple(_ACCELERATION * most for most in limits.qdd)  # (7,) used [rad/s^2]
        self._qddd = tuple((_JERK * most, _HARD * most) for most in limits.qddd)
        self._low = tuple(q + _POSITION_MARGIN for q in limits.q_min)
        self._high = tuple(q - _POSITION_MARGIN for q in limits.q_max)
        lost = _LOST * PERIOD
        self._fastest = tuple(
            qd - lost * qdd - _EPSILON for qd, qdd in zip(limits.qd, limits.qdd, strict=True)
        )

    def step(
        self, q: Sequence[float], qd: Sequence[float], qdd: Sequence[float], wanted: Sequence[float]
    ) -> list[float]:
        """(7,) velocities to command next, from (7,) q, qd and qdd commanded last."""
        return [
            _towards(
                min(max(w, -fast, -speed_at(p - low, a)), fast, speed_at(high - p, a)),
                v,
                dv,
                a,
                soft,
                hard if abs(v + dv * abs(dv) / (2.0 * soft)) > fast + _EPSILON else soft,
            )
            for p, v, dv, w, low, high, fast, a, (soft, hard) in zip(
                q,
                qd,
                qdd,
                wanted,
                self._low,
                self._high,
                self._fastest,
                self.qdd,
                self._qddd,
                strict=True,
            )
        ]


def speed_at(distance: float, qdd: float) -> float:
    """The speed [rad/s] from which a joint comes to rest, softly, within a distance [rad]."""
    if distance <= 0.0:
        return 0.0
    brake = 0.7 * qdd
    return brake / _GAIN * (sqrt(1.0 + 2.0 * _GAIN * _GAIN * distance / brake) - 1.0)


def _towards(
    wanted: float, qd: float, qdd: float, most: float, jerk: float, largest: float
) -> float:
    """One joint, one period, with the largest acceleration that can end in time at this jerk."""
    change, step = wanted - qd, jerk * PERIOD
    left = abs(change)
    goal = min(most, left / PERIOD, 0.5 * (sqrt(step * step + 8.0 * jerk * left) - step))
    if change < 0.0:
        goal = -goal
    step = largest * PERIOD
    return qd + PERIOD * min(max(goal, qdd - step), qdd + step)


class SpeedError(Exception):
    """A joint moves faster than commanded."""


class SpeedMonitor:
    """Compares measured with commanded speeds in one motion."""

    def __init__(self) -> None:
        self._commanded: Sequence[float] = _ZERO
        self._fastest: Sequence[float] = _ZERO
        self._since: float | None = None

    def check(self, now: float, measured: Sequence[float], commanded: Sequence[float]) -> None:
        """Once a period [s], with (7,) velocities [rad/s]; SpeedError: a joint is too fast."""
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
