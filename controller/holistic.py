"""The holistic quadratic qp (Haviland, Sünderhauf and Corke, RA-L 2022, eq. 6-16).

The paper's qp is, with x = (q̇, δ) and the slack δ = ν - J q̇ of the end-effector twist ν,

    min  ½ xᵀ Q x + Cᵀ x    subject to  J q̇ + δ = ν,  velocity dampers,  speed limits.

The slack is free, so it can be put into the cost: with Q = diag(Λ_q, Λ_δ) and C = (c, 0),

    min  ½ q̇ᵀ (Λ_q + Jᵀ Λ_δ J) q̇ + (c - Jᵀ Λ_δ ν)ᵀ q̇    subject to  lower <= q̇ <= upper,

which has the same minimiser, only n variables, and always a solution.
"""

from __future__ import annotations

from math import atan2
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from controller.command import Array
from controller.guidance import StanceBias
from controller.model import RobotModel, manipulability
from controller.qp import QP
from controller.settings import ControllerSettings

_NEVER_SILENT = 0.1
"""What is left of the end effector's weight while guidance is whole."""
_ALWAYS_PULLED = 0.1
"""What is left of the posture's weight where guidance ends."""


class Linearisation(NamedTuple):
    """The robot as one qp sees it."""

    bTe: SE3
    J: Array
    """(6, n) Jacobian at the end effector in base axes."""
    manipulability: float
    """Of the arm."""
    gradient: Array
    """(n,) Ĵ_m of what the settings want to be manipulable (eq. 10)."""
    heading_error: float
    """θ_ε: bearing of the end effector seen from the base [rad] (eq. 11)."""


def linearise(model: RobotModel, settings: ControllerSettings, q: Array) -> Linearisation:
    """Everything about the robot that the qp needs, for joint positions q (7,) [rad]."""
    bTe, J, screws, hessian = model.kinematics(q)
    n_base = model.n_base
    gradient = np.zeros(model.n)
    m, gradient[n_base:] = manipulability(screws[:, n_base:], hessian[n_base:, n_base:])
    if settings.manipulability_of == "whole body":
        gradient = manipulability(screws, hessian)[1]
    elif settings.manipulability_of == "none":
        gradient = np.zeros(model.n)
    x, y, _ = bTe.translation.tolist()
    return Linearisation(bTe, J, m, gradient, atan2(y, x))


def assemble(
    model: RobotModel,
    settings: ControllerSettings,
    linearisation: Linearisation,
    twist: Array,
    error: float,
    bounds: tuple[Array, Array],
    last: Array,
    bias: StanceBias | None = None,
) -> QP:
    """The qp for a desired end-effector twist.

    Args:
        model: the robot.
        settings: the weights.
        linearisation: from `look`.
        twist: (6,) desired end-effector twist ν in base axes [m/s, rad/s].
        error: |e|, distance to the goal [m]; near the goal the twist is followed more strictly
            and the base moves less (eq. 8).
        bounds: lower and upper bounds (n,) of the velocities.
        last: (n,) velocities of the previous period.
        bias: what guidance asks, if anything.
    """
    n_base, J = model.n_base, linearisation.J
    nearness = 1.0 / max(error, settings.smallest_error)
    tracking = nearness  # Λ_δ (eq. 8)
    effort = np.empty(model.n)  # Λ_q (eq. 8)
    effort[:n_base] = settings.base_effort * nearness
    effort[n_base:] = settings.arm_effort
    linear = -settings.manipulability_gain * linearisation.gradient  # c (eq. 9)
    linear[:n_base] -= (
        settings.heading_gain * linearisation.heading_error * model.base_turn
    )  # eq. 12

    if settings.smoothness > 0.0:
        effort += settings.smoothness
        linear -= settings.smoothness * last
    if bias is not None:
        share = bias.share
        tracking = nearness * (1.0 - share) ** 2 + (0.0 if bias.detour else _NEVER_SILENT * share)
        base = settings.base_guidance * share
        arm = settings.posture_guidance * max(share, _ALWAYS_PULLED)
        effort[:n_base] += base
        effort[n_base:] += arm
        linear[:n_base] -= base * bias.base
        linear[n_base:] -= arm * bias.arm

    P = (tracking * J.T) @ J
    P.flat[:: model.n + 1] += effort
    return QP(P, linear - tracking * (twist @ J), *bounds)
