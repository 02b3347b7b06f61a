"""Position-based servoing: the end-effector twist that leads to a pose."""

from __future__ import annotations

from dataclasses import replace
from math import atan2, exp, inf, sqrt
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller.command import Array, PoseGoal
from controller.goal_velocity import GoalVelocity
from controller.settings import ControllerSettings, ServoSettings

_NEAR, _NEAR_ANGLE = 0.04, 0.14
"""Where the twist begins to be steadied; it is wholly at half of this [m and rad]."""


class PoseError(NamedTuple):
    """How far one pose is from another."""

    position: float
    """Distance [m]."""
    orientation: float
    """Angle of the rotation between them [rad]."""
    translation_vector: Array
    """(3,) in the axes that both poses are expressed in [m]."""
    rotation_vector: Array
    """(3,) axis times angle, in the same axes [rad]."""


def pose_error(current: SE3, target: SE3) -> PoseError:
    """The translation and rotation from one pose to another, both in the same frame."""
    translation = target.translation - current.translation
    rotation = current.rotation @ pin.log3(current.actInv(target).rotation)
    return PoseError(_length(translation), _length(rotation), translation, rotation)


def error_norm(settings: ControllerSettings, bTe: SE3, error: PoseError) -> float:
    """|e| of the weights of the QP [m]."""
    if settings.error_norm == "euclidean":
        return error.position
    return float(np.abs(bTe.rotation.T @ error.translation_vector).sum())


class Servo:
    """The end-effector twist that leads to a goal, from period to period.

    What it keeps is how the goal moves, and the last twist.

    Args:
        settings: of the controller. Without guidance, as published, no motion is estimated, and
            going straight is nothing of its own.
    """

    def __init__(self, settings: ControllerSettings) -> None:
        servo, self._period = settings.servo, settings.period
        self._estimates_motion = settings.guidance is not None
        gain, steadying = servo.straight_gain, servo.straight_steadying
        straight = replace(servo, gain=gain, rotation_gain=gain, steadying=steadying)
        self._plain, self._straight = servo, straight if self._estimates_motion else servo
        self.reset()

    def reset(self) -> None:
        """Forget the goal."""
        self._goal_motion = GoalVelocity(self._period)
        self._last = np.zeros(6)

    def with_motion(self, goal: PoseGoal) -> PoseGoal:
        """The goal with the velocity that it seems to have, unless it is given or none."""
        return self._goal_motion(goal) if self._estimates_motion else goal

    def __call__(self, goal: PoseGoal, bTw: SE3, bTe: SE3, error: PoseError) -> Array:
        """The twist ν (6,) that leads to a goal and moves with it, in base axes [m/s, rad/s].

        Near the goal most of the error is noise of the state, and the robot would follow each
        sample of it. There the twist passes a low-pass filter of the first order. Farther away it
        does not, so that the arrival is not delayed.

        Args:
            goal: the goal.
            bTw: the world in the base.
            bTe: the end effector in the base.
            error: from `bTe` to the goal, in base axes.
        """
        settings = self._straight if goal.straight else self._plain
        steadying = settings.steadying
        twist = desired_twist(settings, goal, bTw, bTe, error)
        far = max(error.position / _NEAR, error.orientation / _NEAR_ANGLE)
        if far < 1.0 and steadying > 0.0:
            memory = exp(-self._period / steadying) * min(1.0, 2.0 * (1.0 - far))
            twist += memory * (self._last - twist)
        self._last = twist
        if goal.twist is None:
            return twist
        R = bTw.rotation
        return np.concatenate([twist[:3] + R @ goal.twist[:3], twist[3:] + R @ goal.twist[3:]])


def desired_twist(
    settings: ServoSettings, goal: PoseGoal, bTw: SE3, bTe: SE3, error: PoseError
) -> Array:
    """The twist ν (6,) of the end effector that leads to a goal (Haviland 2022, eq. 17).

    Near the goal it is proportional to the error; with a finite deceleration it is never faster
    than can be braked before the goal, nor than the goal allows. What the goal moves by itself is
    not in it.

    Args:
        settings: gains and decelerations.
        goal: the goal.
        bTw: the world in the base.
        bTe: the end effector in the base.
        error: from `bTe` to the goal, in base axes.

    Returns:
        The twist in base axes, linear first [m/s, rad/s].
    """
    rotation = error.rotation_vector
    if settings.rotation_error == "roll pitch yaw":
        R = bTe.rotation
        rotation = R @ _roll_pitch_yaw(R.T @ bTw.rotation @ goal.wTe.rotation)
    twist = np.empty(6)
    if settings.deceleration < inf:
        distance, angle = error.position, error.orientation
        speed = approach_speed(distance, settings.gain, settings.deceleration, goal.speed)
        twist[:3] = velocity_along(error.translation_vector, distance, speed)
        rate = approach_speed(
            angle, settings.rotation_gain, settings.turn_deceleration, goal.turn_rate
        )
        twist[3:] = velocity_along(rotation, angle, rate)
    else:
        twist[:3] = settings.gain * error.translation_vector
        twist[3:] = settings.rotation_gain * rotation
    return twist


def approach_speed(distance: float, gain: float, deceleration: float, max_speed: float) -> float:
    """Speed at a distance from the goal from which the robot can still brake in time.

    Proportional near the goal as Haviland 2022, eq. 17, then the square root of a constant
    deceleration, joined where their slopes agree, and never above `max_speed`.

    Args:
        distance: what is left, not negative [m or rad].
        gain: speed per distance near the goal [1/s].
        deceleration: [m/s^2 or rad/s^2].
        max_speed: [m/s or rad/s].
    """
    transition = deceleration / (gain * gain)
    if distance <= transition:
        return min(gain * distance, max_speed)
    return min(sqrt(2.0 * deceleration * (distance - transition / 2.0)), max_speed)


def velocity_along(vector: Array, length: float, speed: float) -> Array:
    """A velocity of this speed along a vector of this length; zero if it has no length."""
    return vector * (speed / length) if length > 0.0 else np.zeros_like(vector)


def _length(vector: Array) -> float:
    x, y, z = vector.tolist()
    return sqrt(x * x + y * y + z * z)


def _roll_pitch_yaw(R: Array) -> Array:
    """Roll, pitch and yaw (3,) of a rotation, R = Rz(yaw) Ry(pitch) Rx(roll) [rad]."""
    pitch = atan2(-R[2, 0], sqrt(R[0, 0] ** 2 + R[1, 0] ** 2))
    return np.array([atan2(R[2, 1], R[2, 2]), pitch, atan2(R[1, 0], R[0, 0])])
