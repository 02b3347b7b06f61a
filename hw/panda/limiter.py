"""Limits the commanded velocities in position, velocity, acceleration and jerk.

A step depends only on what the arm reports as commanded last, so lost packets, for which the arm
extrapolates, leave no error behind.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

from hw.panda.library import JointLimits

PERIOD = 0.001  # of the control loop [s]
_LOST = 4  # number of packets in a row that may be lost at the highest speed
_EPSILON = 1e-3  # margin to velocity limits [rad/s], as in the vendor's library
_MARGIN = 0.01  # margin to position limits [rad]
_ACCELERATION, _JERK = 0.95, 0.25  # shares of the limits that are used
_HARD = 0.98  # share of the jerk for a joint that lost packets accelerate beyond its speed
_GAIN = 20.0  # slope of the speed over the distance close to a limit or a goal [1/s]


class VelocityLimiter:
    """Brings the commanded velocities of the joints to the wanted ones."""

    def __init__(self, limits: JointLimits) -> None:
        self.qdd = tuple(_ACCELERATION * most for most in limits.qdd)
        """(7,) accelerations that are used [rad/s^2]."""
        self._qddd = tuple((_JERK * most, _HARD * most) for most in limits.qddd)
        self._low = tuple(q + _MARGIN for q in limits.q_min)
        self._high = tuple(q - _MARGIN for q in limits.q_max)
        lost = _LOST * PERIOD
        self._fastest = tuple(
            qd - lost * qdd - _EPSILON for qd, qdd in zip(limits.qd, limits.qdd, strict=True)
        )

    def step(
        self, q: Sequence[float], qd: Sequence[float], qdd: Sequence[float], wanted: Sequence[float]
    ) -> list[float]:
        """The velocities to command next.

        Args:
            q: (7,) positions commanded last [rad].
            qd: (7,) velocities commanded last [rad/s].
            qdd: (7,) accelerations commanded last [rad/s^2].
            wanted: (7,) velocities to reach [rad/s].

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

    It decelerates with 0.7 qdd [rad/s^2] far away, and more softly near the end.
    """
    if distance <= 0.0:
        return 0.0
    brake = 0.7 * qdd
    return brake / _GAIN * (sqrt(1.0 + 2.0 * _GAIN * _GAIN * distance / brake) - 1.0)


def _towards(
    wanted: float, qd: float, qdd: float, most: float, jerk: float, largest: float
) -> float:
    """One joint, one period, with the largest acceleration that can end in time at this jerk.

    It changes with the largest jerk at most.
    """
    change, step = wanted - qd, jerk * PERIOD
    left = abs(change)
    goal = min(most, left / PERIOD, 0.5 * (sqrt(step * step + 8.0 * jerk * left) - step))
    if change < 0.0:
        goal = -goal
    step = largest * PERIOD
    return qd + PERIOD * min(max(goal, qdd - step), qdd + step)
