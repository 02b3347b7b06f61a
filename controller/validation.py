"""Validation of the inputs of a control step."""

from math import hypot

import numpy as np
from pinocchio import SE3

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


def check_state(state: KinematicState, last: Command) -> None:
    """Check state and last command.

    Raises:
        GoalError: names the input and what is wrong with it.
    """
    numbers = {
        "joint positions": state.q,
        "last base twist": last.base_twist,
        "last joint velocities": last.qd,
    }
    _check(numbers, {"base pose": state.wTb})


def check_goal(goal: MotionGoal | None, joints: int) -> None:
    """Check a goal of an arm by its number of joints.

    Raises:
        GoalError: names what is wrong with it.
    """
    poses: dict[str, SE3] = {}
    numbers: dict[str, Array] = {}
    match goal:
        case PoseGoal():
            poses["goal pose"] = goal.wTe
            if goal.twist is not None:
                numbers["goal twist"] = goal.twist
        case PostureGoal():
            numbers["goal posture"] = goal.q
            if np.shape(goal.q) != (joints,):
                raise GoalError(f"the goal posture must have {joints} joints, got {goal.q}")
        case BaseGoal():
            poses["goal base pose"] = goal.wTb
    for names, least in ((_POSITIVE, "above 0"), (_TOLERANCES, "of at least 0")):
        for name in names:
            value = getattr(goal, name, 1.0)
            if not (value > 0.0 if names is _POSITIVE else value >= 0.0):
                text = name.replace("_", " ")
                raise GoalError(f"the goal's {text} must be a number {least}, got {value}")
    _check(numbers, poses)


def _check(numbers: dict[str, Array], poses: dict[str, SE3]) -> None:
    everything: list[float] = []
    for array in numbers.values():
        everything += array.tolist()
    for pose in poses.values():
        everything += pose.translation.tolist()
    if not hypot(*everything) <= _MAX_SIZE:
        _check_sizes(numbers | {name: pose.homogeneous for name, pose in poses.items()})
    for name, pose in poses.items():
        _check_rotation(name, pose.rotation)


def _check_rotation(name: str, rotation: Array) -> None:
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()
    squares = a * a + b * b + c * c + d * d + e * e + f * f + g * g + h * h + i * i
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    # The product of three singular values is 1 and their squares add up to 3 only if all are 1.
    if not max(abs(squares - 3.0), abs(determinant - 1.0)) < _ROTATION_TOLERANCE:
        raise GoalError(
            f"the {name} must have a rotation matrix, got {np.round(rotation, 4).tolist()}; "
            "its rows must be perpendicular unit vectors"
        )


def _check_sizes(numbers: dict[str, Array]) -> None:
    for name, values in numbers.items():
        if not np.abs(values).max() <= _MAX_SIZE:
            raise GoalError(
                f"the {name} must be finite numbers between -{_MAX_SIZE:g} and {_MAX_SIZE:g}, "
                f"got {np.array(values).tolist()}"
            )
