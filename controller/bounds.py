"""How fast every degree of freedom may move in this period, so that no limit is ever passed."""

from __future__ import annotations

import numpy as np

from controller.command import Array
from controller.model import RobotModel
from controller.settings import ControllerSettings

_SIGNS = np.array([[-1.0], [1.0]])


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
        self._model = model
        self._dampers = dampers = settings.joint_limits
        self._slope = dampers.damper_gain / (dampers.influence_distance - dampers.stop_distance)
        self._speeds = np.abs(model.velocity_limits)
        self._limit_acceleration = settings.limit_acceleration
        acceleration = model.acceleration_limits
        self._max_change = acceleration * settings.period
        self._delay = acceleration * model.description.arm.lag
        self._delay_squared = self._delay**2
        self._twice_acceleration = 2.0 * acceleration

    def __call__(self, q: Array, last: Array) -> tuple[Array, Array]:
        """Lower and upper bounds (n,), lower <= upper in every component.

        Args:
            q: (7,) joint positions [rad].
            last: (n,) velocities of the previous period, base first.
        """
        model, dampers = self._model, self._dampers
        distance = _SIGNS * (model.position_limits - model.joints(q))
        room = distance - dampers.stop_distance
        towards = np.where(distance > dampers.influence_distance, np.inf, self._slope * room)
        if self._limit_acceleration:
            # The speed v from which v lag + v² / 2a is the room that is left.
            root = np.sqrt(self._delay_squared + self._twice_acceleration * np.maximum(room, 0.0))
            towards = np.minimum(towards, root - self._delay)
        bounds = _SIGNS * np.minimum(np.maximum(towards, -dampers.return_speed), self._speeds)
        if self._limit_acceleration:
            change = self._max_change
            bounds = np.minimum(np.maximum(bounds, last - change), last + change)
        return bounds[0], bounds[1]
