"""Velocity bounds of the QP: velocity, acceleration and joint position limits.

The bounds are the intersection of the velocity limits, the velocity dampers of the joint limits
(Haviland 2022, eq. 15 and 16), the speed from which a joint that lags behind its commands still
brakes before its limit, and the velocities that the acceleration limits make reachable. Where these
conflict the acceleration limits win; that happens only to a robot that starts outside its limits.
"""

from __future__ import annotations

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from config.arrays import Array
from controller.limits import Constraints
from controller.model import RobotModel
from controller.settings import ControllerSettings
from controller.situation import Situation
from controller.stance.dexterity import dexterity

_SHORT = 0.4  # share of its range that the distances of a joint get where it is short [1/rad]
_NO_CHOICE = 0.1  # share of the distance from a limit where an arm has few postures for a pose
_UNCERTAIN, _LOST = 0.06, 0.08
"""Uncertainty from which on the base is slower, and at which it has half its speed [m]."""


class VelocityBounds:
    """The limit of velocities, of their changes, and of joint positions."""

    def __init__(self, model: RobotModel, settings: ControllerSettings) -> None:
        limits = model.limits
        self._dampers = settings.joint_limits
        self._limit_acceleration = settings.limit_acceleration
        self._n_base = model.n_base
        lag = model.description.arm.lag
        shares = limits.margins(1.0, _SHORT)
        columns = (limits.q_min, limits.q_max, limits.qd, limits.qdd, shares)
        rows = zip(*(column.tolist() for column in columns), strict=True)
        has_choice = dexterity(model.description).has_choice
        self._stop = self._dampers.stop_distance * (1.0 if has_choice else _NO_CHOICE)
        joints = [self._joint(lag, *row) for row in rows]
        speeds, changes = (
            model.velocity_limits.tolist(),
            model.acceleration_limits * settings.period,
        )
        if not settings.limit_acceleration:
            changes = np.full(model.n, inf)
        dofs = [(-inf, inf, None)] * model.n_base + [(*joint.free, joint) for joint in joints]
        self._dofs = [
            (*rest, *dof) for *rest, dof in zip(*speeds, changes.tolist(), dofs, strict=True)
        ]
        """Of every degree of freedom: velocity limits, change in one period, positions between
        which no position limit is near, and those limits."""

    def _joint(
        self, lag: float, low: float, high: float, speed: float, acceleration: float, share: float
    ) -> _Joint:
        dampers = self._dampers
        stop, influence = share * self._stop, share * dampers.influence_distance
        slope = dampers.damper_gain / (influence - stop)
        braking = speed * lag + speed * speed / (2.0 * acceleration)
        near = max(influence, stop + braking)
        free = low + near, high - near
        return _Joint(low, high, speed, acceleration, lag, stop, influence, slope, free)

    def __call__(self, constraints: Constraints, now: Situation) -> None:
        """Set the bounds; a base that knows its place only so well is slower."""
        lost = (now.surroundings.uncertainty - _UNCERTAIN) / (_LOST - _UNCERTAIN)
        share = 1.0 - 0.5 * min(max(lost, 0.0), 1.0)
        constraints.lower, constraints.upper = self.at(now.state.q, now.applied, share)

    def at(self, q: Array, last: Array, base_share: float = 1.0) -> tuple[Array, Array]:
        """Lower and upper bounds (n,), lower <= upper, [m/s, rad/s].

        `q` are the joint positions (j,) [rad], `last` the velocities (n,) of the previous period,
        `base_share` is the part of its limits that the base may use.
        """
        # Plain floats: on nine numbers they are faster than arrays.
        lower, upper = [], []
        positions, shares = [0.0] * self._n_base + q.tolist(), [base_share] * self._n_base
        shares += [1.0] * len(q)
        rows = zip(positions, last.tolist(), shares, self._dofs, strict=True)
        for position, v, share, (low, high, change, start, end, joint) in rows:
            low, high = share * low, share * high
            if position < start:
                low = -self._approach_speed(joint, position - joint.low)
            if position > end:
                high = self._approach_speed(joint, joint.high - position)
            least, most = v - change, v + change
            lower.append(least if low < least else most if low > most else low)
            upper.append(least if high < least else most if high > most else high)
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
