"""Driving the base to a pose on the floor: straight if it can, along a curve if it has wheels."""

from __future__ import annotations

from math import atan, atan2, copysign, hypot, sin

import numpy as np
from pinocchio import SE3

from controller.command import Array
from controller.model import RobotModel
from controller.servo import approach_speed, directed
from controller.settings import ControllerSettings

_HEADING_PULL = 1.0
_CURVATURE_GAIN = 3.0
_SLOW_IN_CURVES = 0.4
_TURN_ON_THE_SPOT = 0.6
"""Misalignment from which the base turns more than it drives [rad]."""
_NEAR = 0.10
"""Distance below which the base only turns to its final heading and creeps [m]."""


def planar(wTb: SE3) -> tuple[float, float, float]:
    """x, y [m] and heading [rad] of a base pose."""
    x, y = wTb.translation[:2]
    return float(x), float(y), atan2(wTb.rotation[1, 0], wTb.rotation[0, 0])


def wrapped(angle: float) -> float:
    """The same angle in [-pi, pi) [rad]."""
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)


def drive_to(model: RobotModel, settings: ControllerSettings, bTg: SE3) -> Array:
    """Velocities (n_base,) of the base's degrees of freedom that lead to a pose `bTg` seen from it.

    A differential drive follows the smooth control law of Park and Kuipers (ICRA 2011): the
    curvature that turns the path into the goal's heading, and it turns on the spot first when it
    points elsewhere.
    """
    x, y, turn = planar(bTg)
    distance = hypot(x, y)
    v_max, _, w_max = model.limits.base_twist
    gain = settings.servo_gain
    speed = approach_speed(distance, gain, settings.servo_deceleration, v_max)
    turning = copysign(
        approach_speed(abs(turn), gain, settings.servo_turn_deceleration, w_max), turn
    )
    if model.n_base == 3:
        return np.array([*directed(np.array([x, y]), distance, speed), turning])
    if distance < _NEAR:
        return np.array([turning, gain * x])

    bearing = atan2(y, x)
    delta, theta = wrapped(-bearing), wrapped(turn - bearing)
    misaligned = delta - atan(-_HEADING_PULL * theta)
    curvature = (
        -(
            _CURVATURE_GAIN * misaligned
            + (1.0 + _HEADING_PULL / (1.0 + (_HEADING_PULL * theta) ** 2)) * sin(delta)
        )
        / distance
    )
    v = speed / (1.0 + _SLOW_IN_CURVES * curvature * curvature)
    w = curvature * v
    share = min(1.0, max(0.0, abs(misaligned) / _TURN_ON_THE_SPOT - 1.0))
    w = (1.0 - share) * w + share * copysign(min(w_max, gain * abs(misaligned)), -misaligned)
    return np.array([float(np.clip(w, -w_max, w_max)), (1.0 - share) * v])
