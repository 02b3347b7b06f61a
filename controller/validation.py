"""Validation of the inputs of a control step."""

from collections.abc import Callable, Sequence
from math import atan2, hypot, inf
from types import NoneType

import numpy as np
from pinocchio import SE3

from config.planar import Pose2D
from config.poses import MapPose
from controller.command import (
    BaseGoal,
    Command,
    KinematicState,
    MotionGoal,
    PoseGoal,
    PostureGoal,
)

_MAX_SIZE = 1e12  # largest length, angle or speed: sums of squares stay accurate [m, rad and per s]
_ROTATION_TOLERANCE = 1e-4  # for poses written with few digits
_GOALS: tuple[type, ...] = (PoseGoal, PostureGoal, BaseGoal, NoneType)
_POSITIVE = ("speed", "turn_rate")
_TOLERANCES = ("tolerance", "position_tolerance", "orientation_tolerance", "heading_tolerance")


class GoalError(ValueError):
    """A goal, a state, or what a term or limit adds, is of a wrong kind or size or not finite."""


def check_state(state: KinematicState, last: Command, joints: int) -> Pose2D:
    """Check state and last command of an arm by its number of joints; the pose on the floor.

    Raises:
        GoalError: names the input and what is wrong with it.
    """
    mTb = _check_pose("base pose `mTb`", state.mTb)
    q, twist, qd = state.q, last.base_twist, last.qd
    try:
        size = hypot(*q.tolist(), *twist.tolist(), *qd.tolist())
    except (AttributeError, TypeError):
        size = inf
    if not size <= _MAX_SIZE or len(q) != joints or len(qd) != joints or len(twist) != 3:
        check_numbers("the joint positions `q`", q, joints)
        check_numbers("`base_twist` of the last command", twist, 3)
        check_numbers("`qd` of the last command", qd, joints)
    return mTb


def check_goal(goal: MotionGoal[MapPose] | None, joints: int) -> None:
    """Check a goal of an arm by its number of joints.

    Raises:
        GoalError: names what is wrong with it.
    """
    if not isinstance(goal, _GOALS):
        kinds = ", ".join(kind.__name__ for kind in _GOALS)
        raise GoalError(f"the goal must be one of {kinds}, got {type(goal).__name__}")
    match goal:
        case PoseGoal():
            _check_pose("goal pose `target`", goal.target)
            if goal.twist is not None:
                check_numbers("the goal's `twist`", goal.twist, 6)
        case PostureGoal():
            check_numbers("the goal posture `q`", goal.q, joints)
        case BaseGoal():
            _check_pose("goal base pose `target`", goal.target)
    for names, least in ((_POSITIVE, "above 0"), (_TOLERANCES, "of at least 0")):
        for name in names:
            value = getattr(goal, name, 1.0)
            if not (value > 0.0 if names is _POSITIVE else value >= 0.0):
                text = name.replace("_", " ")
                raise GoalError(f"the goal's {text} must be a number {least}, got {value}")


def add_all(kind: str, parts: Sequence[Callable[..., None]], *given: object) -> None:
    """Call each term or limit; a GoalError of what it adds gets its name."""
    try:
        for part in parts:
            part(*given)
    except GoalError as error:
        name = getattr(part, "__name__", type(part).__name__)
        raise GoalError(f"{kind} `{name}`: {error}") from None


def _check_pose(name: str, pose: SE3) -> Pose2D:
    if not isinstance(pose, SE3):
        what = f"got {type(pose).__name__}; SE3(array) makes one of a 4x4 array"
        raise GoalError(f"the {name} must be a pinocchio.SE3, {what}")
    rows = pose.homogeneous.tolist()
    (c, _, _, x), (s, _, _, y), (_, _, _, z), _ = rows
    if not hypot(x, y, z) <= _MAX_SIZE:
        check_numbers(f"the {name}", pose.homogeneous, 4, 4)
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


def check_numbers(
    name: str, given: object, *shape: int | str, least: float = -_MAX_SIZE, most: float = _MAX_SIZE
) -> None:
    """Check an array of this shape, in which a text is any size; without a shape, a number.

    Raises:
        GoalError: says what it must be.
    """
    is_numeric = isinstance(given, float | int | np.number | np.ndarray)
    values = np.asarray(given if is_numeric else None)
    sizes = zip(shape, values.shape, strict=False)
    wanted = tuple(found if isinstance(size, str) else size for size, found in sizes)
    fits = values.dtype.kind in "fiu" and len(shape) == values.ndim and wanted == values.shape
    if not fits or not ((least <= values) & (values <= most)).all():
        what = f"an array {shape} of numbers".replace("'", "") if shape else "a number"
        raise GoalError(f"{name} must be {what} from {least:g} to {most:g}, got {given!r}")
