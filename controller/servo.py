"""Position-based servoing: the end-effector twist that leads to a pose."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller.command import Array


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
    rotation = here.rotation @ pin.log3(here.rotation.T @ there.rotation)
    return PoseError(
        float(np.linalg.norm(translation)), float(np.linalg.norm(rotation)), translation, rotation
    )


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
