"""Stances for a goal: a posture of the arm and the pose of the base, and what they cost."""

from __future__ import annotations

from collections.abc import Callable
from math import atan2, cos, sin
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from controller.command import Array
from controller.floor import Pose2D
from controller.model import RobotModel
from controller.stance.posture_bank import ToolPoses, forward_kinematics
from controller.stance.stance_cost import Start, driving_times, leaving_times
from controller.stance_settings import StanceSettings

REACHED = 1e-3
"""Sum of the errors of height and tilt of a posture that suits the goal [m + rad]."""
_ITERATIONS = 5
"""Of the refinement, which converges quadratically."""
_MAX_ERROR = 0.5
"""Larger errors are cut to this in an iteration, as the equations are linearised [m and rad]."""
_DAMPING = 1e-4
"""Of the least squares, small against J Jᵀ of a regular posture [m² and rad²]."""
_MIN_SINE = 1e-9
"""Keeps a tilt error of zero from being divided by zero."""


class Stance(NamedTuple):
    """How to stand for a goal."""

    q: Array
    """(7,) posture of the arm [rad]."""
    bTe: SE3
    """End effector in the base, for that posture."""
    reverse: bool
    """Whether the base drives there backwards."""
    dock: tuple[float, float] | None = None
    """From where the base can go straight in, the arm in its posture: x and y in the frame of its
    place [m]. None if that is not known."""

    @property
    def bearing(self) -> float:
        """Of the end effector, seen from the base [rad]."""
        x, y, _ = self.bTe.translation.tolist()
        return atan2(y, x)

    def base_for(self, wTe: SE3) -> Pose2D:
        """The base pose that brings the end effector to `wTe`.

        The heading is the turn about the vertical that brings the end effector's rotation in the
        base nearest to the goal's.
        """
        (a, b, c), (d, e, f), _ = self.bTe.rotation.tolist()
        (g, h, i), (j, k, m), _ = wTe.rotation.tolist()
        along = a * g + b * h + c * i + d * j + e * k + f * m
        across = a * j + b * k + c * m - d * g - e * h - f * i
        heading = atan2(across, along)
        cosine, sine = cos(heading), sin(heading)
        x, y, _ = self.bTe.translation.tolist()
        wx, wy, _ = wTe.translation.tolist()
        return Pose2D(wx - (cosine * x - sine * y), wy - (sine * x + cosine * y), heading)


def base_poses(wTe: SE3, tools: ToolPoses) -> Array:
    """x, y, heading (N, 3) of the bases that bring their end effectors to `wTe`."""
    R, p = wTe.rotation, wTe.translation
    positions, rotations = tools.positions, tools.rotations
    c = rotations[:, 0] @ R[0] + rotations[:, 1] @ R[1]
    s = rotations[:, 0] @ R[1] - rotations[:, 1] @ R[0]
    heading = np.arctan2(s, c)
    c, s = np.cos(heading), np.sin(heading)
    x, y = positions[:, 0], positions[:, 1]
    return np.stack([p[0] - (c * x - s * y), p[1] - (s * x + c * y), heading], axis=1)


def stance_costs(
    model: RobotModel,
    settings: StanceSettings,
    start: Start,
    bases: Array,
    postures: Array,
    tools: ToolPoses,
    sideways: float,
) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Costs (N,) of postures at base poses (N, 3) [s], and whether the base backs there (N,).

    `sideways` is by how much the end effector is to point sideways: 0 is straight up or down, 1 is
    horizontal.
    """
    limits, s = model.limits, settings
    driving, reverse = driving_times(model, settings, start, bases)
    folding = (np.abs(postures - start.q) / (s.arm_speed * limits.qd)).max(axis=1)
    margin = np.minimum(postures - limits.q_min, limits.q_max - postures).min(axis=1)
    bearing = np.abs(np.arctan2(tools.positions[:, 1], tools.positions[:, 0]))
    costs = (
        np.maximum(driving, folding)
        + s.overlap * np.minimum(driving, folding)
        + s.manipulability_cost * np.maximum(0.0, s.min_manipulability - tools.manipulability)
        + (s.bearing_cost_down + sideways * (s.bearing_cost - s.bearing_cost_down)) * bearing
        + s.limit_cost * np.maximum(0.0, s.preferred_limit_margin - margin)
    )
    if start.onward is not None:
        costs += leaving_times(model, settings, start.onward, bases)
    return costs, reverse


def refine(model: RobotModel, settings: StanceSettings, wTe: SE3, q: Array) -> tuple[Array, Array]:
    """Move postures (N, 7) until their end effectors have the height and tilt of the goal.

    Three equations: height, and the two angles of the vertical as the end effector sees it. The
    first joint changes neither and stays.

    Returns:
        Postures (N, 7), and the sum of the remaining errors of each (N,) [m + rad].
    """
    height, vertical = wTe.translation[2], wTe.rotation[2]

    def equations(tools: ToolPoses) -> tuple[Array, Array]:
        seen = tools.rotations @ vertical  # the goal's vertical; (0, 0, 1) where the tilt is right
        scale = _angle_per_sine(np.hypot(seen[:, 0], seen[:, 1]), seen[:, 2])
        J = tools.J[:, [2, 3, 4]]
        J[:, :, 0] = 0.0
        rise = height - tools.positions[:, 2]
        return np.stack([rise, seen[:, 1] * scale, -seen[:, 0] * scale], axis=1), J

    return _solve(model, settings, q, equations)


def refine_standing(
    model: RobotModel, settings: StanceSettings, wTe: SE3, q: Array, bases: Array
) -> tuple[Array, Array]:
    """Move postures (N, 7) until they bring the end effector to the goal from bases (N, 3).

    As `refine`, and the bases stay where they are.
    """
    c, s, zero = np.cos(bases[:, 2]), np.sin(bases[:, 2]), np.zeros(len(bases))
    bRw = np.stack([c, s, zero, -s, c, zero, zero, zero, zero + 1.0], axis=1).reshape(-1, 3, 3)
    away = wTe.translation - np.column_stack([bases[:, :2], zero])
    positions, rotations = (bRw @ away[:, :, None])[:, :, 0], bRw @ wTe.rotation

    def equations(tools: ToolPoses) -> tuple[Array, Array]:
        R = rotations @ np.swapaxes(tools.rotations, 1, 2)
        axis = 0.5 * np.stack(
            [R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1
        )
        cosine = 0.5 * (np.trace(R, axis1=1, axis2=2) - 1.0)
        turn = axis * _angle_per_sine(np.linalg.norm(axis, axis=1), cosine)[:, None]
        return np.concatenate([positions - tools.positions, turn], axis=1), tools.J

    return _solve(model, settings, q, equations)


def _angle_per_sine(sine: Array, cosine: Array) -> Array:
    angles: Array = np.arctan2(sine, cosine) / np.maximum(sine, _MIN_SINE)
    return angles


def _solve(
    model: RobotModel,
    settings: StanceSettings,
    q: Array,
    equations: Callable[[ToolPoses], tuple[Array, Array]],
) -> tuple[Array, Array]:
    """Postures (N, 7) that solve M equations, by damped least squares, and what is left (N,).

    Joints that come near a limit stay there.

    Args:
        model: the robot.
        settings: how near to a limit a joint may come.
        q: (N, 7) where to start.
        equations: errors (N, M) and Jacobians (N, M, 7) of postures.
    """
    low = model.limits.q_min + settings.limit_margin
    high = model.limits.q_max - settings.limit_margin
    for _ in range(_ITERATIONS):
        errors, J = equations(forward_kinematics(model.description, q))
        left: Array = np.abs(errors).sum(axis=1)
        if (left < REACHED).all():
            break
        errors = np.clip(errors, -_MAX_ERROR, _MAX_ERROR)
        step = _damped_least_squares(J, errors)
        blocked = (q + step < low) | (q + step > high)
        step = _damped_least_squares(np.where(blocked[:, None, :], 0.0, J), errors)
        q = np.clip(q + step, low, high)
    return q, left


def _damped_least_squares(J: Array, errors: Array) -> Array:
    """Steps (N, 7) for Jacobians (N, M, 7) and errors (N, M)."""
    JT = np.swapaxes(J, 1, 2)
    squares = J @ JT + _DAMPING * np.eye(J.shape[1])
    return (JT @ np.linalg.solve(squares, errors[:, :, None]))[:, :, 0]
