"""How fast every degree of freedom may go right now, so that no limit is ever passed."""

from __future__ import annotations

import numpy as np

from controller.command import Array
from controller.model import RobotModel
from controller.settings import ControllerSettings

_SIDES = np.array([[-1.0], [1.0]])
_RETURN = 0.2
"""A joint outside its limits comes back at most this fast [rad/s]."""


def velocity_bounds(
    model: RobotModel, settings: ControllerSettings, q: Array, last: Array
) -> tuple[Array, Array]:
    """Bounds on the velocities that keep speed, acceleration and joint position limits.

    They are the intersection of the speed limits, the velocity dampers of the joint limits
    (Haviland 2022, eq. 13), the speed from which a joint can still brake before its limit although
    it follows its commands with a lag, and what the acceleration limits make reachable from the
    last velocities. Where braking for a joint limit asks for more than the acceleration allows, the
    acceleration limit wins: the dampers are wide enough that this happens only to a robot that
    starts outside its limits.

    Args:
        model: the robot.
        settings: the dampers' distances and gain, and the control period.
        q: (7,) joint positions [rad].
        last: (n,) velocities of the previous period, base first.

    Returns:
        Lower and upper bounds (n,), lower <= upper in every component.
    """
    slope = settings.damper_gain / (settings.damper_influence - settings.damper_stop)
    distance = _SIDES * (model.position_limits - model.joints(q))
    room = distance - settings.damper_stop
    towards = np.where(distance > settings.damper_influence, np.inf, slope * room)
    if settings.limit_acceleration:
        # The speed v from which v lag + v² / 2a is the room that is left.
        limit, lag = model.acceleration_limits, settings.lag
        braking = np.sqrt((limit * lag) ** 2 + 2.0 * limit * np.maximum(room, 0.0)) - limit * lag
        towards = np.minimum(towards, braking)
    bounds = _SIDES * np.minimum(np.maximum(towards, -_RETURN), model.speed_limits)
    if settings.limit_acceleration:
        step = model.acceleration_limits * settings.period
        bounds = np.minimum(np.maximum(bounds, last - step), last + step)
    return bounds[0], bounds[1]
