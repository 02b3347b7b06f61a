"""Velocities that the arm accepts: inside its limits on position, velocity, acceleration and jerk.

A step depends on nothing but what the arm says it was commanded last. So packets that were lost,
in whose place the arm goes on by itself, leave no error behind.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

from hw.panda.generation import JointLimits

PERIOD = 0.001
"""Of the loop of the arm [s]."""
_LOST = 4
"""Packets in a row that may be lost at the highest speed without leaving the limits."""
_EPSILON = 1e-3
"""Distance that commands keep from limits on velocity [rad/s], as the vendor's library does."""
_MARGIN = 0.01
"""Distance at which joints come to rest before their limits [rad]."""
_ACCELERATION, _JERK = 0.95, 0.25
"""Shares of the limits that are used."""
_HARD = 0.98
"""Share of the jerk for a joint that packets were lost for: it accelerates beyond its speed."""
_GAIN = 20.0
"""Slope of the speed over the distance close to a limit or a goal [1/s]."""


class VelocityLimiter:
    """Leads the commanded velocities of the joints to where they are wanted.

    Args:
        limits: of the arm.
        acceleration: share of its limit that is used, 0 to 1.
        jerk: share of its limit that is used, 0 to 1.
    """

    def __init__(
        self, limits: JointLimits, acceleration: float = _ACCELERATION, jerk: float = _JERK
    ) -> None:
        self.qdd = tuple(acceleration * most for most in limits.qdd)
        """(7,) accelerations that it uses [rad/s^2]."""
        self._qddd = tuple((jerk * most, _HARD * most) for most in limits.qddd)
        self._low = tuple(q + _MARGIN for q in limits.q_min)
        self._high = tuple(q - _MARGIN for q in limits.q_max)
        lost = _LOST * PERIOD
        self._fastest = tuple(
            qd - lost * qdd - _EPSILON for qd, qdd in zip(limits.qd, limits.qdd, strict=True)
        )

    def step(
        self,
        q: Sequence[float],
        qd: Sequence[float],
        qdd: Sequence[float],
        wanted: Sequence[float],
    ) -> list[float]:
        """The velocities to command next.

        Args:
            q: (7,) positions commanded last [rad].
            qd: (7,) velocities commanded last [rad/s].
            qdd: (7,) accelerations commanded last [rad/s^2].
            wanted: (7,) velocities to come to [rad/s].

        Returns:
            (7,) velocities one period later [rad/s].
        """
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
    """The speed [rad/s] from which a joint comes to rest within a distance [rad].

    It brakes with 0.7 qdd [rad/s^2] from afar and ever more softly in the end.
    """
    if distance <= 0.0:
        return 0.0
    brake = 0.7 * qdd
    return brake / _GAIN * (sqrt(1.0 + 2.0 * _GAIN * _GAIN * distance / brake) - 1.0)


def _towards(
    wanted: float, qd: float, qdd: float, most: float, jerk: float, largest: float
) -> float:
    """One joint, one period: the acceleration is the largest that can end in time at this jerk.

    It changes with the largest jerk at most.
    """
    change, step = wanted - qd, jerk * PERIOD
    left = abs(change)
    goal = min(most, left / PERIOD, 0.5 * (sqrt(step * step + 8.0 * jerk * left) - step))
    if change < 0.0:
        goal = -goal
    step = largest * PERIOD
    return qd + PERIOD * min(max(goal, qdd - step), qdd + step)
