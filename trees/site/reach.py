"""Whether a robot can be where a task sends it, wherever it stands."""

from __future__ import annotations

from math import degrees, pi

import numpy as np

from behaviours import Posture, ToolPose
from controller import Array, out_of_reach
from robots import RobotDescription

_ROUNDING = 1e-3
"""Degrees in files are rounded [rad]."""
_UP = 0.5
"""With this cosine between its approach and the vertical the hand points up."""
_DIPS = 0.005
"""Finger tips this far below the floor are below it [m]."""


def why_not_reached(value: object, robot: RobotDescription) -> tuple[str, str] | None:
    """Message and hint about a place where the robot cannot be; None if it can."""
    if isinstance(value, Posture):
        return _beyond_joints(value.q, robot)
    if not isinstance(value, ToolPose):
        return None
    tip = value.wTe.act(np.array([0.0, 0.0, robot.gripper.tip]))
    lowest = min(tip[2], value.wTe.translation[2])
    if lowest < -_DIPS:
        return f"the hand would be {-lowest:.2f} m below the floor", "give it another height"
    why = out_of_reach(robot, value.wTe)
    tilt = "change its height or tilt; roll 180 looks down"
    return (f"out of reach: {why}", tilt) if why else None


def points_up(value: object) -> bool:
    """Whether a place has the hand look up, which nobody means who grasps from above."""
    return isinstance(value, ToolPose) and bool(value.wTe.rotation[2, 2] > _UP)


def _beyond_joints(q: Array, robot: RobotDescription) -> tuple[str, str] | None:
    low, high = robot.limits.q_min - _ROUNDING, robot.limits.q_max + _ROUNDING
    beyond = np.flatnonzero((q < low) | (q > high))
    if len(beyond) == 0:
        return None
    joint = int(beyond[0])
    first, last = (degrees(float(end[joint])) for end in (robot.limits.q_min, robot.limits.q_max))
    message = (
        f"joint {joint + 1} of `{robot.name}` goes from {first:.0f}° to {last:.0f}°, "
        f"not to {degrees(float(q[joint])):g}°"
    )
    meant = np.degrees(q)  # as if the numbers were radians
    if (np.abs(meant) <= 2.0 * pi).all() and ((meant >= low) & (meant <= high)).all():
        angles = ", ".join(f"{degrees(angle):.0f}" for angle in meant)
        return message, f"did you mean [{angles}]? These look like radians"
    return message, f"write {first:.0f} to {last:.0f}"
