"""Builds the holistic QP (Haviland, Sünderhauf and Corke, RA-L 2022, eq. 6-16).

The paper's QP is, with x = (q̇, δ) (eq. 9) and the slack δ = ν - J q̇ of the end-effector twist ν,

    min  ½ xᵀ Q x + Cᵀ x    subject to  J q̇ + δ = ν,  velocity dampers,  X⁻ <= x <= X⁺.   (6)

The slack can be eliminated: with Q = diag(Λ_q, Λ_δ) (eq. 10) and C = (c, 0) (eq. 11),

    min  ½ q̇ᵀ (Λ_q + Jᵀ Λ_δ J) q̇ + (c - Jᵀ Λ_δ ν)ᵀ q̇    subject to  lower <= q̇ <= upper,

which has the same minimiser, only n variables, and always a solution; the bounds of the slack (±10
in the published example) are left out. Not in the paper: smoothness term, bias towards a stance,
acceleration bounds, a least |e| in the weights 1/|e|, a desired bearing other than 0 (eq. 13), and
the manipulability as a share of what is usual for the arm.
"""

from math import atan2
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from controller.command import Array
from controller.floor.base_drive import wrap
from controller.model import RobotModel, manipulability
from controller.qp_solver import QP
from controller.settings import ControllerSettings
from controller.stance.bank_drawing import dexterity
from controller.stance.bias import StanceBias


class Linearisation(NamedTuple):
    """Kinematics and gradients at one posture."""

    bTe: SE3
    J: Array  # (6, n) Jacobian at the end effector in base axes
    manipulability: float  # of the arm
    gradient: Array  # (n,) Ĵ_m of the manipulability of the settings, times its gain (eq. 12)
    heading_error: float  # θ_ε: bearing of the end effector seen from the base [rad] (eq. 13)


def linearise(
    model: RobotModel,
    settings: ControllerSettings,
    q: Array,
    before: Linearisation | None = None,
) -> Linearisation:
    """Kinematics and gradients at joint positions q (j,) [rad].

    With a linearisation shortly before, manipulability and gradient are taken from it.
    """
    if before is not None:
        bTe, J = model.tool(q)
        m, gradient = before.manipulability, before.gradient
    else:
        bTe, J, screws, hessian = model.kinematics(q)
        n_base = model.n_base
        gradient = np.zeros(model.n)
        m, gradient[n_base:] = manipulability(screws[:, n_base:], hessian[n_base:, n_base:])
        if settings.manipulability_of == "whole body":
            gradient = manipulability(screws, hessian)[1]
        elif settings.manipulability_of == "none":
            gradient = np.zeros(model.n)
        gradient *= settings.manipulability_gain / dexterity(model.description)
    x, y, _ = bTe.translation.tolist()
    return Linearisation(bTe, J, m, gradient, atan2(y, x))


def build_qp(
    model: RobotModel,
    settings: ControllerSettings,
    linearisation: Linearisation,
    twist: Array,
    error: float,
    bounds: tuple[Array, Array],
    last: Array,
    bias: StanceBias | None = None,
    bearing: float = 0.0,
    *,
    base_rests: bool = False,
) -> QP:
    """The QP for a desired end-effector twist.

    Args:
        model: the robot.
        settings: the weights.
        linearisation: from `linearise`.
        twist: (6,) desired end-effector twist ν in base axes [m/s, rad/s].
        error: |e|, distance to the goal [m], in the weights λ_δ and λ_q (eq. 14).
        bounds: lower and upper bounds (n,) of the velocities.
        last: (n,) velocities of the previous period.
        bias: towards a stance.
        bearing: desired bearing of the end effector seen from the base [rad].
        base_rests: whether the arm moves alone as far as it reaches.
    """
    n_base, J = model.n_base, linearisation.J
    if bias is not None and bias.coasting is not None:
        base = J[:, :n_base]
        twist = twist - (1.0 - bias.response) * (base @ bias.coasting)
        J = np.hstack([bias.response * base, J[:, n_base:]])
    tracking = 1.0 / max(error, settings.min_error)  # λ_δ
    base_effort, arm_effort = settings.base_effort * tracking, settings.arm_effort  # λ_q (eq. 14)
    if base_rests:
        base_effort += settings.resting_effort
    smoothness = settings.smoothness
    wanted = linearisation.gradient + smoothness * last  # -C (eq. 11)
    wanted[model.turning] += settings.heading_gain * wrap(linearisation.heading_error - bearing)
    if bias is not None:
        tracking = tracking * (1.0 - bias.blend) ** 2 + bias.min_tracking
        base_effort += bias.base_weight
        arm_effort += bias.posture_weight
        wanted += bias.pull

    tracked = tracking * J.T
    P = tracked @ J
    efforts = [base_effort + smoothness] * n_base + [arm_effort + smoothness] * (model.n - n_base)
    diagonal = P.reshape(-1)[:: model.n + 1]
    diagonal += efforts
    return QP(P, tracked @ -twist - wanted, *bounds)
