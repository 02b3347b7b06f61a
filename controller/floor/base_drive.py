"""Drives the base to a pose on the floor: straight if holonomic, along a curve if differential."""

from __future__ import annotations

from math import asin, atan, atan2, copysign, hypot, inf, sin
from typing import NamedTuple

import numpy as np

from config.arrays import Array
from config.planar import ORIGIN, Pose2D, wrap
from controller.model import RobotModel
from controller.servo import approach_speed
from controller.settings import ControllerSettings

# The control law of a differential drive (Park and Kuipers, ICRA 2011).
_HEADING_GAIN = 0.6  # k1: how strongly the path bends to arrive with the goal's heading
_DETOUR = 0.6
"""Largest deviation of the path from the straight way, to arrive with the goal's heading [m]:
farther away the path is the tangent of a circle of this radius around the goal."""
_CURVATURE_GAIN = 2.0  # k2: how fast the base turns onto that path
_CURVATURE_SLOWDOWN = 0.1  # β: how much slower it drives where the path is curved [m^2]
_PIVOT_ANGLE = 0.6  # misalignment with the path from which it turns more than it drives [rad]
_PIVOT_BLEND = 0.8  # misalignment beyond that at which it does not drive at all [rad]
_ARRIVAL_DISTANCE = 0.06  # nearer than this it only turns to its final heading and creeps [m]

# Following a path.
_ON_THE_SPOT = 0.6  # a base that points away from the path by more turns on the spot [rad]
_BLEND = 0.35  # up to this much less it turns and drives [rad]


class Lead(NamedTuple):
    """Where the base is led now on its way to a pose."""

    target: Pose2D  # where to steer, in the base frame: the pose itself or a point on the path
    reverse: bool  # drive there backwards
    final: bool  # whether the target is the pose itself, and the way there is free
    speed: float  # largest speed on the path [m/s]
    time_left: float  # least time to the pose [s]
    unreachable: str = ""  # why there is no path; empty if there is one

    @classmethod
    def nowhere(cls, reverse: bool, why: str = "") -> Lead:
        """To stay, as long as there is no path."""
        return cls(ORIGIN, reverse, False, 0.0, inf, why)


STAY = Lead(ORIGIN, False, True, inf, 0.0)
"""Where a base is led that is at its pose."""


def drive_to(
    model: RobotModel,
    settings: ControllerSettings,
    target: Pose2D,
    *,
    reverse: bool = False,
    max_speed: float = inf,
) -> Array:
    """Velocities (n_base,) towards a pose in the base frame [m/s, rad/s].

    A differential drive follows the smooth control law of Park and Kuipers (ICRA 2011), and turns
    on the spot first when it points elsewhere; in reverse its back is its front.
    """
    x, y, turn = target
    distance = hypot(x, y)
    servo = settings.servo
    gain = servo.gain
    travel, w_max = travel_speed(model, x, distance, reverse), float(model.limits.base_twist[2])
    speed = approach_speed(distance, gain, servo.deceleration, min(travel, max_speed))
    turning = copysign(approach_speed(abs(turn), gain, servo.turn_deceleration, w_max), turn)
    if model.n_base == 3:
        scale = speed / distance if distance > 0.0 else 0.0
        return np.array([scale * x, scale * y, turning])
    if reverse:
        x, y = -x, -y
    back = min(speed, travel_speed(model, x, distance, not reverse))
    creep = max(-back, min(speed, gain * x))
    far = min(1.0, max(0.0, distance / _ARRIVAL_DISTANCE - 1.0))
    if far == 0.0:
        return np.array([turning, -creep if reverse else creep])

    misalignment, curvature = _path(Pose2D(x, y, turn), distance)
    v = speed / (1.0 + _CURVATURE_SLOWDOWN * curvature * curvature)
    w = curvature * v
    pivot = min(1.0, max(0.0, (abs(misalignment) - _PIVOT_ANGLE) / _PIVOT_BLEND))
    w = (1.0 - pivot) * w + pivot * copysign(min(w_max, gain * abs(misalignment)), -misalignment)
    v = far * (1.0 - pivot) * v + (1.0 - far) * creep
    w = max(-w_max, min(w_max, far * w + (1.0 - far) * turning))
    return np.array([w, -v if reverse else v])


def _path(target: Pose2D, distance: float) -> tuple[float, float]:
    """Misalignment with the path to a pose in front [rad], and its curvature [1/m]."""
    bearing = atan2(target.y, target.x)
    delta, theta = wrap(-bearing), wrap(target.heading - bearing)
    k1 = _HEADING_GAIN
    aim = -atan(k1 * theta)
    follows = -k1 / (1.0 + (k1 * theta) ** 2) * sin(delta)
    if abs(sin(aim)) * distance > _DETOUR:
        aim = copysign(asin(_DETOUR / distance), aim)
        follows = sin(aim)
    misalignment = delta - aim
    curvature = -(_CURVATURE_GAIN * misalignment + sin(delta) - follows) / distance
    return misalignment, curvature


def travel_speed(model: RobotModel, x: float, distance: float, reverse: bool) -> float:
    """Largest speed of the base on its way to a place at x in the base frame [m/s]."""
    limits = model.limits
    forward = float(limits.base_twist[0])
    if model.n_base == 3:
        # Only the component along -x has the reverse speed.
        return min(forward, limits.base_reverse * (distance / -x)) if x < 0.0 else forward
    return limits.base_reverse if reverse else forward


def time_to_drive(model: RobotModel, target: Pose2D, reverse: bool = False) -> float:
    """Least time to a pose in the base frame: turning, driving, turning [s]."""
    x, y, turn = target
    distance = hypot(x, y)
    v_max, w_max = travel_speed(model, x, distance, reverse), float(model.limits.base_twist[2])
    if model.n_base == 3:
        return max(distance / v_max, abs(turn) / w_max)
    if distance < _ARRIVAL_DISTANCE:
        return distance / v_max + abs(turn) / w_max
    bearing = atan2(-y, -x) if reverse else atan2(y, x)
    return distance / v_max + (abs(bearing) + abs(wrap(turn - bearing))) / w_max


def drive_along(
    model: RobotModel, settings: ControllerSettings, lead: Lead, max_speed: float = inf
) -> Array:
    """Velocities (n_base,) that follow a lead [m/s, rad/s].

    A point ahead on the path is reached on the arc through it (pure pursuit); a base that points
    elsewhere turns on the spot first.
    """
    x, y, turn = lead.target
    if lead.final:
        return drive_to(model, settings, lead.target, reverse=lead.reverse, max_speed=max_speed)
    if lead.speed == 0.0:
        return np.zeros(model.n_base)
    servo, w_max = settings.servo, float(model.limits.base_twist[2])
    distance = hypot(x, y)
    speed = min(lead.speed, travel_speed(model, x, distance, lead.reverse), max_speed)
    if model.n_base == 3:
        w = copysign(approach_speed(abs(turn), servo.gain, servo.turn_deceleration, w_max), turn)
        scale = speed / distance if distance > 0.0 else 0.0
        return np.array([scale * x, scale * y, w])
    if lead.reverse:
        x, y = -x, -y
    bearing = atan2(y, x)
    drive = min(1.0, max(0.0, (_ON_THE_SPOT - abs(bearing)) / _BLEND))
    w = copysign(approach_speed(abs(bearing), servo.gain, servo.turn_deceleration, w_max), bearing)
    curvature = 2.0 * y / (distance * distance)
    speed = min(speed, w_max / max(abs(curvature), 1e-6))
    w = drive * curvature * speed + (1.0 - drive) * w
    v = drive * speed
    return np.array([w, -v if lead.reverse else v])
