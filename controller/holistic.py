"""The holistic quadratic programme (Haviland, Sünderhauf and Corke, RA-L 2022, eq. 6-16).

The paper's programme is, with x = (q̇, δ) and the slack δ = ν - J q̇ of the end-effector twist ν,

    min  ½ xᵀ Q x + Cᵀ x    subject to  J q̇ + δ = ν,  velocity dampers,  speed limits.

The slack is free, so it can be put into the cost: with Q = diag(Λ_q, Λ_δ) and C = (c, 0),

    min  ½ q̇ᵀ (Λ_q + Jᵀ Λ_δ J) q̇ + (c - Jᵀ Λ_δ ν)ᵀ q̇    subject to  lower <= q̇ <= upper,

which has the same minimiser, only n variables, and always a solution.
"""

from __future__ import annotations

from math import atan2
from typing import NamedTuple

import numpy as np
import piqp
from pinocchio import SE3

from controller.command import Array
from controller.model import RobotModel, manipulability
from controller.settings import ControllerSettings


class Programme(NamedTuple):
    """A strictly convex quadratic programme over box bounds: min ½ xᵀ P x + cᵀ x."""

    P: Array
    """(n, n) symmetric, positive definite."""
    c: Array
    """(n,)."""
    lower: Array
    """(n,)."""
    upper: Array
    """(n,)."""


class Situation(NamedTuple):
    """The robot as one programme sees it."""

    bTe: SE3
    J: Array
    """(6, n) Jacobian at the end effector in base axes."""
    manipulability: float
    gradient: Array
    """(7,) of the manipulability [1/rad]."""
    heading_error: float
    """θ_ε: bearing of the end effector seen from the base [rad] (eq. 11)."""


def look(model: RobotModel, q: Array) -> Situation:
    """Everything about the robot that the programme needs, for joint positions q (7,) [rad]."""
    bTe, J = model.jacobian(q)
    m, gradient = manipulability(J[:, model.n_base :])
    return Situation(bTe, J, m, gradient, atan2(bTe.translation[1], bTe.translation[0]))


def assemble(
    model: RobotModel,
    settings: ControllerSettings,
    situation: Situation,
    twist: Array,
    error: float,
    bounds: tuple[Array, Array],
) -> Programme:
    """The programme for a desired end-effector twist.

    Args:
        model: the robot.
        settings: the weights.
        situation: from `look`.
        twist: (6,) desired end-effector twist ν in base axes [m/s, rad/s].
        error: |e|, distance to the goal [m]; near the goal the twist is followed more strictly
            and the base moves less (eq. 8).
        bounds: lower and upper bounds (n,) of the velocities.
    """
    n_base = model.n_base
    tracking = 1.0 / max(error, settings.smallest_error)
    effort = np.full(model.n, settings.arm_effort)
    effort[:n_base] = settings.base_effort * tracking

    linear = np.zeros(model.n)
    linear[n_base:] = -settings.manipulability_gain * situation.gradient
    linear[:n_base] -= settings.heading_gain * situation.heading_error * model.base_turn

    J = situation.J
    return Programme(
        P=np.diag(effort) + tracking * (J.T @ J),
        c=linear - tracking * (twist @ J),
        lower=bounds[0],
        upper=bounds[1],
    )


class Solver:
    """PIQP with its workspace kept from one programme to the next of the same size."""

    def __init__(self) -> None:
        self._piqp = piqp.DenseSolver()
        self._piqp.settings.eps_abs = 1e-8
        self._piqp.settings.eps_rel = 1e-8
        self._piqp.settings.check_duality_gap = True
        self._ready = False

    def solve(self, programme: Programme) -> Array | None:
        """The minimiser (n,), inside the bounds to the last bit; None if PIQP found none."""
        P = np.asfortranarray(programme.P)
        # A component whose bounds coincide leaves the interior-point method no interior.
        lower, upper = programme.lower - 1e-9, programme.upper + 1e-9
        if self._ready:
            self._piqp.update(P=P, c=programme.c, x_l=lower, x_u=upper)
        else:
            self._piqp.setup(P=P, c=programme.c, x_l=lower, x_u=upper)
            self._ready = True
        if self._piqp.solve() != piqp.PIQP_SOLVED:
            self._ready = False
            return None
        x: Array = np.clip(self._piqp.result.x, programme.lower, programme.upper)
        return x
