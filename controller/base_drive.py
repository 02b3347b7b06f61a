"""Driving the base to a pose on the floor: straight if it can, along a curve if it has wheels."""

from __future__ import annotations

from math import atan, atan2, copysign, cos, hypot, inf, pi, sin
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from controller.command import Array
from controller.model import RobotModel
from controller.servo import approach_speed
from controller.settings import ControllerSettings

_HEADING_PULL = 1.0
_CURVATURE_GAIN = 3.0
_SLOW_IN_CURVES = 0.4
_TURN_ON_THE_SPOT = 0.6
"""Misalignment from which the base turns more than it drives [rad]."""
_ONLY_TURNING = 0.8
"""Misalignment beyond that at which it does not drive at all [rad]."""
_NEAR = 0.15
"""Distance below which the base only turns to its final heading and creeps [m]."""


class Planar(NamedTuple):
    """A pose on the floor."""

    x: float
    """[m]."""
    y: float
    """[m]."""
    heading: float
    """[rad]."""

    def seen_from(self, here: Planar) -> Planar:
        """This pose in the frame of another one; the heading in [-pi, pi)."""
        dx, dy = self.x - here.x, self.y - here.y
        c, s = cos(here.heading), sin(here.heading)
        return Planar(c * dx + s * dy, c * dy - s * dx, wrapped(self.heading - here.heading))


def planar(wTb: SE3) -> Planar:
    """The pose on the floor of a base pose in space."""
    (x, y, _), rotation = wTb.translation.tolist(), wTb.rotation
    return Planar(x, y, atan2(rotation[1, 0], rotation[0, 0]))


def wrapped(angle: float) -> float:
    """The same angle in [-pi, pi) [rad]."""
    return (angle + pi) % (2.0 * pi) - pi


def drive_to(
    model: RobotModel,
    settings: ControllerSettings,
    there: Planar,
    *,
    reverse: bool = False,
    fastest: float = inf,
) -> Array:
    """Velocities of the base's degrees of freedom that lead to a pose.

    A differential drive follows the smooth control law of Park and Kuipers (ICRA 2011): the
    curvature that turns the path into the goal's heading, and it turns on the spot first when it
    points elsewhere. In reverse it does the same with its back as its front.

    Args:
        model: the robot.
        settings: gain and decelerations of the approach.
        there: the pose, seen from the base.
        reverse: drive backwards.
        fastest: largest speed, if less than the robot's own [m/s].

    Returns:
        (n_base,) velocities [m/s, rad/s].
    """
    x, y, turn = there
    distance = hypot(x, y)
    v_max, _, w_max = model.limits.base_twist.tolist()
    gain = settings.servo_gain
    speed = approach_speed(distance, gain, settings.servo_deceleration, min(v_max, fastest))
    turning = copysign(
        approach_speed(abs(turn), gain, settings.servo_turn_deceleration, w_max), turn
    )
    if model.n_base == 3:
        share = speed / distance if distance > 0.0 else 0.0
        return np.array([share * x, share * y, turning])
    if reverse:
        x, y = -x, -y
    creep = max(-speed, min(speed, gain * x))
    far = min(1.0, max(0.0, distance / _NEAR - 1.0))
    if far == 0.0:
        return np.array([turning, -creep if reverse else creep])

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
    spot = min(1.0, max(0.0, (abs(misaligned) - _TURN_ON_THE_SPOT) / _ONLY_TURNING))
    w = (1.0 - spot) * w + spot * copysign(min(w_max, gain * abs(misaligned)), -misaligned)
    v = far * (1.0 - spot) * v + (1.0 - far) * creep
    w = max(-w_max, min(w_max, far * w + (1.0 - far) * turning))
    return np.array([w, -v if reverse else v])


def time_to_drive(model: RobotModel, there: Planar, reverse: bool = False) -> float:
    """Least time to a pose seen from the base, turning, driving, turning [s]."""
    x, y, turn = there
    distance = hypot(x, y)
    v_max, w_max = float(model.limits.base_twist[0]), float(model.limits.base_twist[2])
    if model.n_base == 3:
        return max(distance / v_max, abs(turn) / w_max)
    if distance < _NEAR:
        return distance / v_max + abs(turn) / w_max
    way = atan2(-y, -x) if reverse else atan2(y, x)
    return distance / v_max + (abs(way) + abs(wrapped(turn - way))) / w_max


def wheel_speeds(base_twist: Array, radius: float, track: float) -> tuple[float, float]:
    """Left and right wheel speeds [rad/s] of a differential drive (Haviland 2022, eq. 4).

    Args:
        base_twist: (3,) vx, vy, ω in the base frame; vy must be 0 [m/s, m/s, rad/s].
        radius: of the wheels [m].
        track: distance between them [m].
    """
    v, w = float(base_twist[0]), float(base_twist[2])
    return (v - w * track / 2.0) / radius, (v + w * track / 2.0) / radius
