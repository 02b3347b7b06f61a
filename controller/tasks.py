"""The QP that each kind of goal asks for, and what is told of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from controller.command import Array, KinematicState, PostureGoal
from controller.floor import Pose2D
from controller.model import RobotModel
from controller.qp_solver import QP
from controller.servo import approach_speed
from controller.settings import ControllerSettings


class GoalQP(NamedTuple):
    """What one kind of goal asks for."""

    qp: QP
    position_error: float = np.nan
    orientation_error: float = np.nan
    arrived: bool = False
    twist: Array | None = None
    """(6,) the end-effector twist that is desired, in base axes; None if none is."""
    base_time: float = 0.0
    posture_error: float = 0.0
    unreachable: str = ""
    stance: Pose2D | None = None
    blend: float = 0.0
    detour: bool = False
    base_velocity: Array | None = None
    """(n_base,) where the base is led, however fast it is now; None if it is not."""
    arm_alone: Callable[[Array], QP | None] = lambda base: None
    """(n_base,) velocities of the base to the QP in which the arm makes up for its lag; None where
    there is nothing to make up for."""


def to_posture(
    model: RobotModel,
    settings: ControllerSettings,
    state: KinematicState,
    goal: PostureGoal,
    bounds: tuple[Array, Array],
) -> GoalQP:
    """The arm to joint positions, all joints arriving together; the base comes to rest."""
    servo, limits = settings.servo, model.limits
    error = goal.q - state.q
    max_error = float(np.abs(error).max())
    deceleration = limits.qdd.min() * servo.joint_deceleration
    speeds = [
        approach_speed(abs(e), servo.gain, deceleration, qd)
        for e, qd in zip(error, limits.qd, strict=True)
    ]
    duration = max(abs(e) / v if v > 0.0 else 0.0 for e, v in zip(error, speeds, strict=True))
    qd = error / duration if duration > 0.0 else np.zeros_like(error)
    desired = np.concatenate([np.zeros(model.n_base), qd])
    qp = qp_towards(desired, bounds)
    arrived = max_error <= goal.tolerance
    return GoalQP(qp, 0.0, max_error, arrived=arrived, posture_error=max_error)


def qp_towards(velocities: Array, bounds: tuple[Array, Array]) -> QP:
    """The QP whose minimiser is nearest to velocities (n,)."""
    return QP(np.eye(len(velocities)), -velocities, *bounds)


def with_base(bounds: tuple[Array, Array], velocities: Array) -> tuple[Array, Array]:
    """Bounds (n,) in which the base has these velocities (n_base,)."""
    lower, upper = bounds[0].copy(), bounds[1].copy()
    lower[: len(velocities)] = upper[: len(velocities)] = velocities
    return lower, upper
