"""Validation of the inputs of a control step."""

from math import atan2, hypot

import numpy as np
from pinocchio import SE3

from config.planar import Pose2D
from config.poses import MapPose
from controller.command import (
    Array,
    BaseGoal,
    Command,
    KinematicState,
    MotionGoal,
    PoseGoal,
    PostureGoal,
)

_MAX_SIZE = 1e12  # largest length, angle or speed: sums of squares stay accurate [m, rad and per s]
_ROTATION_TOLERANCE = 1e-4  # for poses written with few digits
_POSITIVE = ("speed", "turn_rate")
_TOLERANCES = ("tolerance", "position_tolerance", "orientation_tolerance", "heading_tolerance")


class GoalError(ValueError):
    """A goal or state with numbers that are not finite, or a matrix that is not a rotation."""


def check_state(state: KinematicState, last: Command) -> Pose2D:
    """Check state and last command; the pose on the floor.

    Raises:
        GoalError: names the input and what is wrong with it.
    """
    mTb = _check_pose("base pose", state.mTb)
    if not hypot(*state.q.tolist(), *last.base_twist.tolist(), *last.qd.tolist()) <= _MAX_SIZE:
        _check_size("joint positions", state.q)
        _check_size("last base twist", last.base_twist)
        _check_size("last joint velocities", last.qd)
    return mTb


def check_goal(goal: MotionGoal[MapPose] | None, joints: int) -> None:
    """Check a goal of an arm by its number of joints.

    Raises:
        GoalError: names what is wrong with it.
    """
    match goal:
        case PoseGoal():
            _check_pose("goal pose", goal.target)
            if goal.twist is not None:
                _check_size("goal twist", goal.twist)
        case PostureGoal():
            _check_size("goal posture", goal.q)
            if np.shape(goal.q) != (joints,):
                raise GoalError(f"the goal posture must have {joints} joints, got {goal.q}")
        case BaseGoal():
            _check_pose("goal base pose", goal.target)
    for names, least in ((_POSITIVE, "above 0"), (_TOLERANCES, "of at least 0")):
        for name in names:
            value = getattr(goal, name, 1.0)
            if not (value > 0.0 if names is _POSITIVE else value >= 0.0):
                text = name.replace("_", " ")
                raise GoalError(f"the goal's {text} must be a number {least}, got {value}")


def _check_pose(name: str, pose: SE3) -> Pose2D:
    rows = pose.homogeneous.tolist()
    (c, _, _, x), (s, _, _, y), (_, _, _, z), _ = rows
    if not hypot(x, y, z) <= _MAX_SIZE:
        _check_size(name, pose.homogeneous)
    if not _has_rotation(rows):
        raise GoalError(
            f"the {name} must have a rotation matrix, got {np.round(pose.rotation, 4).tolist()}; "
            "its rows must be perpendicular unit vectors"
        )
    return Pose2D(x, y, atan2(s, c))


def is_rotation(pose: SE3) -> bool:
    """Whether the matrix of a pose is a rotation, up to rounding."""
    return _has_rotation(pose.homogeneous.tolist())


def _has_rotation(rows: list[list[float]]) -> bool:
    (a, b, c, _), (d, e, f, _), (g, h, i, _), _ = rows
    squares = a * a + b * b + c * c + d * d + e * e + f * f + g * g + h * h + i * i
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    # The product of three singular values is 1 and their squares add up to 3 only if all are 1.
    return max(abs(squares - 3.0), abs(determinant - 1.0)) < _ROTATION_TOLERANCE


def _check_size(name: str, values: Array) -> None:
    if not np.abs(values).max() <= _MAX_SIZE:
        raise GoalError(
            f"the {name} must be finite numbers between -{_MAX_SIZE:g} and {_MAX_SIZE:g}, "
            f"got {np.array(values).tolist()}"
        )
