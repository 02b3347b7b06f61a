"""How fast every degree of freedom may move in this period, so that no limit is ever passed."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from controller.command import Array
from controller.model import RobotModel
from controller.settings import ControllerSettings, JointLimitSettings


class VelocityBounds:
    """Bounds on the velocities that keep velocity, acceleration and joint position limits.

    They are the intersection of the velocity limits, the velocity dampers of the joint limits
    (Haviland 2022, eq. 15 and 16), the speed from which a joint can still brake before its limit
    although it follows its commands with a lag, and what the acceleration limits make reachable
    from the last velocities. Where braking for a joint limit asks for more than the acceleration
    allows, the acceleration limit wins: the dampers are wide enough that this happens only to a
    robot that starts outside its limits.

    Args:
        model: the robot.
        settings: the dampers, and the control period.
    """

    def __init__(self, model: RobotModel, settings: ControllerSettings) -> None:
        limits = model.limits
        self._dampers = dampers = settings.joint_limits
        self._slope = dampers.damper_gain / (dampers.influence_distance - dampers.stop_distance)
        self._limit_acceleration = settings.limit_acceleration
        self._lower, self._upper = model.velocity_limits.tolist()
        self._changes = (model.acceleration_limits * settings.period).tolist()
        self._n_base = model.n_base
        lag = model.description.arm.lag
        self._joints = [
            _Joint.of(*numbers, lag, dampers)
            for numbers in zip(
                limits.q_min.tolist(),
                limits.q_max.tolist(),
                limits.qd.tolist(),
                limits.qdd.tolist(),
                strict=True,
            )
        ]

    def __call__(self, q: Array, last: Array) -> tuple[Array, Array]:
        """Lower and upper bounds (n,), lower <= upper in every component.

        Args:
            q: (7,) joint positions [rad].
            last: (n,) velocities of the previous period, base first.
        """
        # Plain floats: on nine numbers they are faster than arrays.
        lower, upper = self._lower.copy(), self._upper.copy()
        for number, (joint, position) in enumerate(
            zip(self._joints, q.tolist(), strict=True), self._n_base
        ):
            if position < joint.free_from:
                lower[number] = -self._towards(joint, position - joint.low)
            if position > joint.free_to:
                upper[number] = self._towards(joint, joint.high - position)
        if self._limit_acceleration:
            for number, (v, change) in enumerate(zip(last.tolist(), self._changes, strict=True)):
                least, most = v - change, v + change
                lower[number] = _between(least, lower[number], most)
                upper[number] = _between(least, upper[number], most)
        return np.array(lower), np.array(upper)

    def _towards(self, joint: _Joint, distance: float) -> float:
        """Speed at which a joint may approach a limit that is this far away [rad/s]."""
        dampers = self._dampers
        room = distance - dampers.stop_distance
        speed = joint.speed
        if distance <= dampers.influence_distance:
            speed = min(speed, self._slope * room)
        if self._limit_acceleration:
            # The speed v from which v lag + v² / 2a is the room that is left.
            delay = joint.acceleration * joint.lag
            root = sqrt(delay * delay + 2.0 * joint.acceleration * max(room, 0.0))
            speed = min(speed, root - delay)
        return max(speed, -dampers.return_speed)


def _between(least: float, value: float, most: float) -> float:
    return least if value < least else most if value > most else value


class _Joint(NamedTuple):
    """Of the arm; angles in rad."""

    low: float
    high: float
    speed: float
    acceleration: float
    lag: float
    free_from: float
    """Between this and ..."""
    free_to: float
    """... this no limit is so near that it matters."""

    @classmethod
    def of(
        cls,
        low: float,
        high: float,
        speed: float,
        acceleration: float,
        lag: float,
        dampers: JointLimitSettings,
    ) -> _Joint:
        """A joint with these limits."""
        braking = speed * lag + speed * speed / (2.0 * acceleration)
        matters = max(dampers.influence_distance, dampers.stop_distance + 1.001 * braking)
        return cls(low, high, speed, acceleration, lag, low + matters, high - matters)
