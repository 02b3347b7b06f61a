"""Velocity bounds of the QP: velocity, acceleration and joint position limits.

The bounds are the intersection of the velocity limits, the velocity dampers of the joint limits
(Haviland 2022, eq. 15 and 16), the speed from which a joint that lags behind its commands still
brakes before its limit, and the velocities that the acceleration limits make reachable. Where these
conflict the acceleration limits win; that happens only to a robot that starts outside its limits.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from controller.command import Array
from controller.model import RobotModel
from controller.settings import ControllerSettings

_SHORT = 0.4  # share of its range that the distances of a joint get where it is short [1/rad]


class VelocityBounds:
    """Computes the bounds of one control period."""

    def __init__(self, model: RobotModel, settings: ControllerSettings) -> None:
        limits = model.limits
        self._dampers = settings.joint_limits
        self._limit_acceleration = settings.limit_acceleration
        self._lower, self._upper = model.velocity_limits.tolist()
        self._changes = (model.acceleration_limits * settings.period).tolist()
        self._n_base = model.n_base
        lag = model.description.arm.lag
        shares = limits.margins(1.0, _SHORT)
        columns = (limits.q_min, limits.q_max, limits.qd, limits.qdd, shares)
        rows = zip(*(column.tolist() for column in columns), strict=True)
        joints = [self._joint(lag, *row) for row in rows]
        self._joints = [(n, *joint.free, joint) for n, joint in enumerate(joints, model.n_base)]

    def _joint(
        self, lag: float, low: float, high: float, speed: float, acceleration: float, share: float
    ) -> _Joint:
        dampers = self._dampers
        stop, influence = share * dampers.stop_distance, share * dampers.influence_distance
        slope = dampers.damper_gain / (influence - stop)
        braking = speed * lag + speed * speed / (2.0 * acceleration)
        near = max(influence, stop + 1.001 * braking)
        free = low + near, high - near
        return _Joint(low, high, speed, acceleration, lag, stop, influence, slope, free)

    def __call__(self, q: Array, last: Array, base_share: float = 1.0) -> tuple[Array, Array]:
        """Lower and upper bounds (n,), lower <= upper, [m/s, rad/s].

        `q` are the joint positions (j,) [rad], `last` the velocities (n,) of the previous period,
        `base_share` is the part of its limits that the base may use.
        """
        # Plain floats: on nine numbers they are faster than arrays.
        lower, upper = self._lower.copy(), self._upper.copy()
        if base_share < 1.0:
            for number in range(self._n_base):
                lower[number] *= base_share
                upper[number] *= base_share
        for (number, start, end, joint), position in zip(self._joints, q.tolist(), strict=True):
            if position < start:
                lower[number] = -self._approach_speed(joint, position - joint.low)
            if position > end:
                upper[number] = self._approach_speed(joint, joint.high - position)
        if self._limit_acceleration:
            for number, (v, change) in enumerate(zip(last.tolist(), self._changes, strict=True)):
                least, most, low, high = v - change, v + change, lower[number], upper[number]
                lower[number] = least if low < least else most if low > most else low
                upper[number] = least if high < least else most if high > most else high
        return np.array(lower), np.array(upper)

    def _approach_speed(self, joint: _Joint, distance: float) -> float:
        """Speed at which a joint may approach a limit at this distance [rad/s]."""
        dampers = self._dampers
        room = distance - joint.stop
        speed = joint.speed
        if distance <= joint.influence:
            speed = min(speed, joint.slope * room)
        if self._limit_acceleration:
            # The speed v from which v lag + v² / 2a is the remaining room.
            delay = joint.acceleration * joint.lag
            root = sqrt(delay * delay + 2.0 * joint.acceleration * max(room, 0.0))
            speed = min(speed, root - delay)
        return max(speed, -dampers.return_speed)


class _Joint(NamedTuple):
    """Limits of an arm joint [rad, rad/s, rad/s², s]."""

    low: float
    high: float
    speed: float
    acceleration: float
    lag: float
    stop: float  # ρ_s: distance at which motion towards the limit stops [rad] ...
    influence: float  # ... and at which the damper begins [rad]
    slope: float  # of the damper [1/s]
    free: tuple[float, float]  # positions between which no limit is near enough to matter [rad]
