"""Refusing what no controller can follow: numbers that are not finite, and poses that are none."""

from __future__ import annotations

from typing import NoReturn

import numpy as np

from controller.command import (
    Array,
    BaseGoal,
    Command,
    KinematicState,
    MotionGoal,
    PoseGoal,
    PostureGoal,
)

_LARGEST = 1e12
"""Larger numbers are no lengths or speeds, and their squares do not add up [m, rad and per s]."""
_ROUNDING = 1e-4
"""A rotation matrix may be this far from one, as poses written with few digits are."""


class GoalError(ValueError):
    """A goal or a state that is not finite, or a pose whose rotation is none."""


def require_sound(state: KinematicState, goal: MotionGoal | None, last: Command) -> None:
    """Check everything that goes into a step.

    Raises:
        GoalError: saying which of it is wrong and how.
    """
    poses = {"base pose": state.wTb}
    numbers = {
        "joint positions": state.q,
        "last base twist": last.base_twist,
        "last joint velocities": last.qd,
    }
    match goal:
        case PoseGoal():
            poses["goal pose"], numbers["goal twist"] = goal.wTe, goal.twist
        case PostureGoal():
            numbers["goal posture"] = goal.q
        case BaseGoal():
            poses["goal base pose"] = goal.wTb
    together = np.concatenate([*numbers.values(), *(pose.translation for pose in poses.values())])
    if not np.abs(together).max() <= _LARGEST:
        _refuse(numbers | {name: pose.homogeneous for name, pose in poses.items()})
    for name, pose in poses.items():
        _require_rotation(name, pose.rotation)


def _require_rotation(name: str, rotation: Array) -> None:
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()
    squares = a * a + b * b + c * c + d * d + e * e + f * f + g * g + h * h + i * i
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    # The product of three singular values is 1 and their squares add up to 3 only if all are 1.
    if not (abs(squares - 3.0) < _ROUNDING and abs(determinant - 1.0) < _ROUNDING):
        raise GoalError(
            f"the {name} must have a rotation matrix, got {np.round(rotation, 4).tolist()}; "
            "its rows must be perpendicular unit vectors"
        )


def _refuse(numbers: dict[str, Array]) -> NoReturn:
    name, values = next(
        (name, values) for name, values in numbers.items() if not np.abs(values).max() <= _LARGEST
    )
    raise GoalError(
        f"the {name} must be finite numbers of size {_LARGEST:g} at most, "
        f"got {np.array(values).tolist()}"
    )
