"""The terms of the holistic QP, each beside its formula.

The QP of Haviland, Sünderhauf and Corke, RA-L 2022, is, with x = (q̇, δ) (eq. 9) and the slack
δ = ν - J q̇ of the end-effector twist ν (eq. 7),

    min  ½ xᵀ Q x + Cᵀ x    subject to  J q̇ + δ = ν,  velocity dampers,  X⁻ <= x <= X⁺.   (6)

With Q = diag(Λ_q, Λ_δ) (eq. 10) and C = (c, 0) (eq. 11) the slack can be eliminated:

    min  ½ q̇ᵀ (Λ_q + Jᵀ Λ_δ J) q̇ + (c - Jᵀ Λ_δ ν)ᵀ q̇    subject to  lower <= q̇ <= upper,

which has the same minimiser, only n variables, and always a solution; the bounds of the slack (±10
in the published example) are left out. Each term adds its part of this cost.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from config.arrays import Array
from config.planar import wrap
from config.poses import MapPose
from controller.command import PoseGoal
from controller.model import RobotModel
from controller.qp_solver import QP
from controller.situation import Situation
from controller.stance.bias import StanceBias
from controller.stance.dexterity import dexterity
from controller.validation import check_numbers


class Aim(NamedTuple):
    """What a pose goal wants of one period."""

    goal: PoseGoal[MapPose]
    twist: Array  # (6,) desired end-effector twist ν in base axes [m/s, rad/s] (eq. 17)
    error: float  # |e|: distance to the goal, in the weights λ_δ and λ_q [m]
    last: Array  # (n,) velocities of the last period, without compensation of the base's lag
    base_rests: bool = False  # whether the arm moves alone as far as it reaches
    bearing: float = 0.0  # desired bearing of the end effector seen from the base [rad]
    bias: StanceBias | None = None  # towards a stance
    compensates: float = 0.0  # share of the base's lag that the arm compensates for


class Cost:
    """The cost ½ q̇ᵀ P q̇ + cᵀ q̇ of one period, to which terms add.

    Where it `checks`, for terms that are not from here, what is not finite or has a wrong size is a
    GoalError.
    """

    def __init__(self, model: RobotModel, *, checks: bool = False) -> None:
        self._checks = checks
        self._n, self._n_base = model.n, model.n_base
        self._P: Array | None = None
        self._c: Array | float = 0.0
        self.pull = np.zeros(model.n)  # (n,) of all linear parts, which c gets the negative of
        self._base = self._arm = self._all = 0.0  # weights that whole parts share

    def track(self, J: Array, twist: Array, weight: float) -> None:
        """Add ½ w |J q̇ - ν|², for J (m, n) and ν (m,)."""
        if self._checks:
            check_numbers("J of `track`", J, "m", self._n)
            check_numbers("the twist of `track`", twist, len(J))
            check_numbers("the weight of `track`", weight, least=0.0)
        weighted = weight * J.T
        self._add(np.dot(weighted, J), np.dot(weighted, -twist))

    def towards(self, velocities: Array, weight: float | Array) -> None:
        """Add ½ Σ w (q̇ - v)², for v (n,) and one weight or (n,)."""
        if self._checks:
            sizes = () if np.isscalar(weight) else (self._n,)
            check_numbers("the velocities of `towards`", velocities, self._n)
            check_numbers("the weight of `towards`", weight, *sizes, least=0.0)
        if isinstance(weight, np.ndarray):
            self._add(np.diag(weight), -weight * velocities)
        else:
            self._all += weight
            self.reward(weight * velocities)

    def resist(self, base: float, arm: float) -> None:
        """Add ½ w |q̇|², with one weight for the base and one for the arm."""
        if self._checks:
            check_numbers("the weight of the base of `resist`", base, least=0.0)
            check_numbers("the weight of the arm of `resist`", arm, least=0.0)
        self._base += base
        self._arm += arm

    def reward(self, gradient: Array) -> None:
        """Add -gᵀ q̇, for g (n,): motion along g is worth so much."""
        if self._checks:
            check_numbers("the gradient of `reward`", gradient, self._n)
        self.pull += gradient

    def _add(self, P: Array, c: Array) -> None:
        self._P, self._c = (P, c) if self._P is None else (self._P + P, self._c + c)

    def qp(self, lower: Array, upper: Array) -> QP:
        """The QP of all terms within bounds (n,)."""
        P = np.zeros((self._n, self._n)) if self._P is None else self._P
        base, arm = self._base + self._all, self._arm + self._all
        diagonal = P.reshape(-1)[:: self._n + 1]
        diagonal += [base] * self._n_base + [arm] * (self._n - self._n_base)
        return QP(P, self._c - self.pull, lower, upper)


Term: TypeAlias = Callable[[Cost, Situation, Aim], None]
"""Adds its part of the cost of a pose goal."""


def _trust(now: Situation, aim: Aim) -> float:
    """1/|e|, which stops growing near the goal."""
    return 1.0 / max(aim.error, now.settings.min_error)


def tracking(cost: Cost, now: Situation, aim: Aim) -> None:
    """½ λ_δ |J q̇ - ν|², the slack of the twist (eq. 6-8, 10), with λ_δ = 1/|e|.

    Led to a stance with the blend s it is (1 - s)² λ_δ + λ_s. A base that takes up only the share r
    of a new command, and has the velocity b, moves with r q̇ + (1 - r) b.
    """
    J, twist, bias, weight = now.kinematics.J, aim.twist, aim.bias, _trust(now, aim)
    if bias is not None:
        weight = weight * (1.0 - bias.blend) ** 2 + bias.min_tracking
        if bias.coasting is not None:
            n_base = now.model.n_base
            base = J[:, :n_base]
            twist = twist - (1.0 - bias.response) * (base @ bias.coasting)
            J = np.hstack([bias.response * base, J[:, n_base:]])
    cost.track(J, twist, weight)


def effort(cost: Cost, now: Situation, aim: Aim) -> None:
    """½ Σ λ_q q̇², with λ_q = k_b/|e| of the base and k_a of the arm (eq. 14)."""
    cost.resist(now.settings.base_effort * _trust(now, aim), now.settings.arm_effort)


def manipulability(cost: Cost, now: Situation, aim: Aim) -> None:
    """-Ĵ_mᵀ q̇: the arm gets more manipulable (eq. 11, 12), as a share of what is usual for it."""
    cost.reward(now.kinematics.gradient)


def heading(cost: Cost, now: Situation, aim: Aim) -> None:
    """-k_ε (θ_ε - θ) ω: the base turns until it sees the hand at the bearing θ (eq. 11, 13).

    The paper has θ = 0, as an arm that a swivel turns to the front prefers it.
    """
    turn = now.settings.heading_gain * wrap(now.kinematics.heading_error - aim.bearing)
    cost.pull[now.model.turning] += turn


def resting_base(cost: Cost, now: Situation, aim: Aim) -> None:
    """½ k |q̇_b|² for a goal with `base_rests`: an arm that can moves alone as far as it reaches."""
    if aim.base_rests and dexterity(now.model.description).has_choice:
        cost.resist(now.settings.resting_effort, 0.0)


def smoothness(cost: Cost, now: Situation, aim: Aim) -> None:
    """½ k |q̇ - q̇_last|²: little change from period to period."""
    cost.towards(aim.last, now.settings.smoothness)


def stance(cost: Cost, now: Situation, aim: Aim) -> None:
    """½ λ_v |q̇_b - v|² + ½ λ_w |q̇_a - w|²: base and arm go to the stance (`StanceBias`)."""
    if aim.bias is not None:
        cost.resist(aim.bias.base_weight, aim.bias.posture_weight)
        cost.reward(aim.bias.pull)


PAPER_TERMS: tuple[Term, ...] = (tracking, effort, manipulability, heading)
STANDARD_TERMS: tuple[Term, ...] = (*PAPER_TERMS, resting_base, smoothness, stance)
