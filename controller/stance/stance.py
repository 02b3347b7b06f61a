"""Stances: arm postures with base poses, and inverse kinematics of many postures at once."""

from collections.abc import Callable
from math import atan2
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from config.arrays import Array
from config.planar import Pose2D, about_z, rotate
from config.poses import MapPose
from controller.model import RobotModel
from controller.stance.dexterity import dexterity, stance_margins
from controller.stance.tool_poses import ToolPoses, forward_kinematics

REACHED = 1e-3  # largest sum of errors of a posture that reaches the goal [m + rad]
_ITERATIONS = 5
_MAX_ERROR = 0.5  # errors are clipped to this in an iteration [m and rad]
_DAMPING = 1e-4  # of the damped least squares [m² and rad²]
_MIN_SINE = 1e-9


class Stance(NamedTuple):
    """How to stand for a goal: the base pose follows from the goal."""

    q: Array  # (j,) posture of the arm [rad]
    bTe: SE3  # end effector in the base, for that posture
    reverse: bool  # whether the base drives there backwards
    dock: float | None = None
    """Where the base starts to go straight in, the arm in its posture: so far ahead of its pose, or
    behind if negative [m]; None if it is not known."""

    @property
    def bearing(self) -> float:
        """Of the end effector, seen from the base [rad]."""
        x, y, _ = self.bTe.translation.tolist()
        return atan2(y, x)

    def base_for(self, mTe: MapPose) -> Pose2D:
        """The base pose that brings the end effector to `mTe`, up to errors of height and tilt."""
        (a, b, c), (d, e, f), _ = self.bTe.rotation.tolist()
        (g, h, i), (j, k, m), _ = mTe.rotation.tolist()
        along = a * g + b * h + c * i + d * j + e * k + f * m
        across = a * j + b * k + c * m - d * g - e * h - f * i
        heading = atan2(across, along)
        x, y = rotate(heading, *self.bTe.translation[:2].tolist())
        wx, wy, _ = mTe.translation.tolist()
        return Pose2D(wx - x, wy - y, heading)


def base_poses(mTe: MapPose, tools: ToolPoses) -> Array:
    """Base poses x, y, heading (N, 3) that bring the end effectors to `mTe`."""
    R, p = mTe.rotation, mTe.translation
    positions, rotations = tools.positions, tools.rotations
    c = rotations[:, 0] @ R[0] + rotations[:, 1] @ R[1]
    s = rotations[:, 0] @ R[1] - rotations[:, 1] @ R[0]
    heading = np.arctan2(s, c)
    x, y = rotate(heading, positions[:, 0], positions[:, 1])
    return np.stack([p[0] - x, p[1] - y, heading], axis=1)


def refine(model: RobotModel, mTe: MapPose, q: Array) -> tuple[Array, Array]:
    """Inverse kinematics of height and tilt of a goal, from postures (N, j); the base is free.

    The swivel of the arm changes neither and stays. Returns postures (N, j), and the sums of their
    errors (N,) [m + rad].
    """
    height, vertical = mTe.translation[2], mTe.rotation[2]
    swivel = model.description.swivel

    def equations(tools: ToolPoses) -> tuple[Array, Array]:
        seen = tools.rotations @ vertical  # the goal's vertical; (0, 0, 1) at the right tilt
        scale = _angle_per_sine(np.hypot(seen[:, 0], seen[:, 1]), seen[:, 2])
        J = tools.J[:, [2, 3, 4]]
        if swivel is not None:
            J[:, :, swivel.joint] = 0.0
        rise = height - tools.positions[:, 2]
        return np.stack([rise, seen[:, 1] * scale, -seen[:, 0] * scale], axis=1), J

    return _solve(model, q, equations)


def refine_standing(model: RobotModel, mTe: MapPose, q: Array, bases: Array) -> tuple[Array, Array]:
    """Inverse kinematics of a goal from postures (N, j) on fixed bases (N, 3); as `refine`."""
    bRw = about_z(-bases[:, 2])
    away = mTe.translation - np.pad(bases[:, :2], ((0, 0), (0, 1)))
    positions, rotations = (bRw @ away[:, :, None])[:, :, 0], bRw @ mTe.rotation

    def equations(tools: ToolPoses) -> tuple[Array, Array]:
        R = rotations @ np.swapaxes(tools.rotations, 1, 2)
        axis = 0.5 * np.stack(
            [R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1
        )
        cosine = 0.5 * (np.trace(R, axis1=1, axis2=2) - 1.0)
        turn = axis * _angle_per_sine(np.linalg.norm(axis, axis=1), cosine)[:, None]
        return np.concatenate([positions - tools.positions, turn], axis=1), tools.J

    return _solve(model, q, equations)


def unwound(model: RobotModel, postures: Array, q: Array) -> Array:
    """Postures (N, j) with those turns of whole joints that bring them nearest to q (j,) [rad]."""
    limits = model.limits
    wide = (limits.q_max - limits.q_min > 2.0 * np.pi) & ~model.description.arm.slides
    if not wide.any():
        return postures
    nearest = postures + 2.0 * np.pi * np.round((q - postures) / (2.0 * np.pi))
    margins = stance_margins(model.description)
    inside = (nearest > limits.q_min + margins) & (nearest < limits.q_max - margins)
    return np.where(wide & inside, nearest, postures)


def _angle_per_sine(sine: Array, cosine: Array) -> Array:
    angles: Array = np.arctan2(sine, cosine) / np.maximum(sine, _MIN_SINE)
    return angles


def _solve(
    model: RobotModel, q: Array, equations: Callable[[ToolPoses], tuple[Array, Array]]
) -> tuple[Array, Array]:
    """Postures (N, j) that solve M equations by damped least squares, and their errors (N,).

    Joints near a limit stay, and others take over where the arm has a choice. `equations` gives
    errors (N, M) and Jacobians (N, M, j).
    """
    margins = stance_margins(model.description)
    has_choice = dexterity(model.description).has_choice
    low, high = model.limits.q_min + margins, model.limits.q_max - margins
    for _ in range(_ITERATIONS):
        errors, J = equations(forward_kinematics(model.description, q))
        left: Array = np.abs(errors).sum(axis=1)
        if (left < REACHED).all():
            break
        errors = np.clip(errors, -_MAX_ERROR, _MAX_ERROR)
        step = _damped_least_squares(J, errors)
        if has_choice:
            blocked = (q + step < low) | (q + step > high)
            step = _damped_least_squares(np.where(blocked[:, None, :], 0.0, J), errors)
        q = np.clip(q + step, low, high)
    return q, left


def _damped_least_squares(J: Array, errors: Array) -> Array:
    """Steps (N, j) for Jacobians (N, M, j) and errors (N, M)."""
    JT = np.swapaxes(J, 1, 2)
    squares = J @ JT + _DAMPING * np.eye(J.shape[1])
    return (JT @ np.linalg.solve(squares, errors[:, :, None]))[:, :, 0]
