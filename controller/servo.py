"""Position-based servoing: the end-effector twist that leads to a pose."""

from __future__ import annotations

from math import atan2, inf, sqrt
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller.command import Array, PoseGoal
from controller.settings import ControllerSettings


class PoseError(NamedTuple):
    """How far one pose is from another."""

    position: float
    """Distance [m]."""
    orientation: float
    """Angle of the rotation between them [rad]."""
    translation_vector: Array
    """(3,) from here to there, in the axes that both poses are given in [m]."""
    rotation_vector: Array
    """(3,) axis times angle from here to there, in the same axes [rad]."""


def pose_error(here: SE3, there: SE3) -> PoseError:
    """The translation and rotation that lead from one pose to another, both in the same frame."""
    translation = there.translation - here.translation
    R = here.rotation
    rotation = R @ pin.log3(R.T @ there.rotation)
    return PoseError(_length(translation), _length(rotation), translation, rotation)


def desired_twist(
    settings: ControllerSettings, goal: PoseGoal, bTw: SE3, here: SE3, error: PoseError
) -> Array:
    """The twist ν (6,) of the end effector that leads to a goal (Haviland 2022, eq. 17).

    Near the goal it is proportional to the error; with a finite deceleration it is never faster
    than can be braked before the goal, nor than the goal allows. The goal's own twist is added.

    Args:
        settings: gains and decelerations.
        goal: the goal.
        bTw: the world in the base.
        here: the end effector in the base.
        error: from `here` to the goal, in base axes.

    Returns:
        The twist in base axes, linear first [m/s, rad/s].
    """
    limited = settings.servo_deceleration < inf
    turn = error.rotation_vector
    if settings.rotation_error == "roll pitch yaw":
        turn = here.rotation @ _roll_pitch_yaw(here.rotation.T @ bTw.rotation @ goal.wTe.rotation)
    twist = np.empty(6)
    if limited:
        s, v = settings, error.position
        speed = approach_speed(v, s.servo_gain, s.servo_deceleration, goal.speed)
        twist[:3] = directed(error.translation_vector, v, speed)
        w = error.orientation
        rate = approach_speed(w, s.rotation_gain, s.servo_turn_deceleration, goal.turn_rate)
        twist[3:] = directed(turn, w, rate)
    else:
        twist[:3] = settings.servo_gain * error.translation_vector
        twist[3:] = settings.rotation_gain * turn
    if goal.twist.any():
        R = bTw.rotation
        twist[:3] += R @ goal.twist[:3]
        twist[3:] += R @ goal.twist[3:]
    return twist


def approach_speed(distance: float, gain: float, deceleration: float, fastest: float) -> float:
    """Speed at a distance from the goal that can still be braked in time.

    Proportional near the goal as Haviland 2022, eq. 17, then the square root of a constant
    deceleration, joined where their slopes agree, and never above `fastest`.

    Args:
        distance: what is left, not negative [m or rad].
        gain: speed per distance near the goal [1/s].
        deceleration: [m/s^2 or rad/s^2].
        fastest: [m/s or rad/s].
    """
    joint = deceleration / (gain * gain)
    if distance <= joint:
        return min(gain * distance, fastest)
    return min(sqrt(2.0 * deceleration * (distance - joint / 2.0)), fastest)


def directed(vector: Array, length: float, speed: float) -> Array:
    """A velocity of the given speed along a vector of the given length; zero for no length."""
    return vector * (speed / length) if length > 0.0 else np.zeros_like(vector)


def norm_of(settings: ControllerSettings, here: SE3, error: PoseError) -> float:
    """|e| of the qp's weights [m]."""
    if settings.distance == "euclidean":
        return error.position
    return float(np.abs(here.rotation.T @ error.translation_vector).sum())


def _length(vector: Array) -> float:
    x, y, z = vector.tolist()
    return sqrt(x * x + y * y + z * z)


def _roll_pitch_yaw(R: Array) -> Array:
    """Roll, pitch and yaw (3,) of a rotation, R = Rz(yaw) Ry(pitch) Rx(roll) [rad]."""
    pitch = atan2(-R[2, 0], sqrt(R[0, 0] ** 2 + R[1, 0] ** 2))
    return np.array([atan2(R[2, 1], R[2, 2]), pitch, atan2(R[1, 0], R[0, 0])])
