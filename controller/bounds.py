"""How fast every degree of freedom may go right now, so that no limit is ever passed."""

from __future__ import annotations

import numpy as np

from controller.command import Array
from controller.model import RobotModel
from controller.settings import ControllerSettings


def velocity_bounds(
    model: RobotModel, settings: ControllerSettings, q: Array, last: Array
) -> tuple[Array, Array]:
    """Bounds on the velocities that keep speed, acceleration and joint position limits.

    They are the intersection of the speed limits, the velocity dampers of the joint limits
    (Haviland 2022, eq. 13), the speed from which a joint can still brake before its limit, and
    what the acceleration limits make reachable from the last velocities. Where braking for a joint
    limit asks for more than the acceleration allows, the acceleration limit wins: the dampers are
    wide enough that this happens only to a robot that starts outside its limits.

    Args:
        model: the robot.
        settings: the dampers' distances and gain, and the control period.
        q: (7,) joint positions [rad].
        last: (n,) velocities of the previous period, base first.

    Returns:
        Lower and upper bounds (n,), lower <= upper in every component.
    """
    limits, n_base = model.limits, model.n_base
    to_upper, to_lower = limits.q_max - q, q - limits.q_min

    upper = model.speed_limits.copy()
    lower = -upper
    upper[n_base:] = np.minimum(upper[n_base:], _towards_limit(to_upper, limits.qdd, settings))
    lower[n_base:] = np.maximum(lower[n_base:], -_towards_limit(to_lower, limits.qdd, settings))

    step = model.acceleration_limits * settings.period
    return np.clip(lower, last - step, last + step), np.clip(upper, last - step, last + step)


def _towards_limit(distance: Array, qdd: Array, settings: ControllerSettings) -> Array:
    """Fastest speed towards a joint limit at a distance (7,) from it; negative means away."""
    room = distance - settings.damper_stop
    damper = settings.damper_gain * room / (settings.damper_influence - settings.damper_stop)
    damper[distance > settings.damper_influence] = np.inf
    braking = np.sqrt(2.0 * qdd * np.maximum(room, 0.0))
    return np.where(room > 0.0, np.minimum(damper, braking), damper)
