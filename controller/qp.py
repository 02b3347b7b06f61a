"""Quadratic programs (QPs) over box bounds, and PIQP to solve them."""

from __future__ import annotations

from typing import NamedTuple

import eigenpy
import numpy as np
import numpy.typing as npt
import piqp

from controller.command import Array

Mask = npt.NDArray[np.bool_]

_BOUND_TOLERANCE = 1e-12
"""The solution of a linear system is inside the bounds if it passes them by no more than this."""
_SOFT_TOLERANCE = 1e-6
"""The same for soft bounds, whose rows are not scaled."""
_SOFT_SOLVES = 3
"""QPs that are solved at most to find out which soft bounds are passed."""
_PIVOTS = 4
"""Corrections of the active set that was guessed from the last QP, before PIQP is asked ..."""
_FINAL_PIVOTS = 20
"""... and of the one that PIQP's answer shows, for the exact minimiser."""
_WIDENING = 1e-8
"""The bounds are this much wider for PIQP: where they coincide there is no interior."""
HIGH_PRECISION = 1e-10
"""Of PIQP; a coarser solution saves no iterations to speak of."""
SOFT_PRECISION = 1e-7
"""Of PIQP with soft bounds, whose weight spreads the numbers over many orders of magnitude."""


class QP(NamedTuple):
    """A strictly convex QP over box bounds: min ½ xᵀ P x + cᵀ x, lower <= x <= upper."""

    P: Array
    """(n, n) symmetric, positive definite."""
    c: Array
    """(n,)."""
    lower: Array
    """(n,)."""
    upper: Array
    """(n,)."""


class _ActiveSet(NamedTuple):
    """Which bounds are active, as factors of 0 and 1 that turn P into the reduced system."""

    at_lower: Array
    """(n,)."""
    at_upper: Array
    """(n,)."""
    free: Array
    """(n,)."""
    sign: Array
    """(n,) 1 at a lower bound, -1 at an upper one: times the gradient it is the multiplier."""
    mask: Array
    """(n, n) 1 where row and column are free."""
    identity: Array
    """(n, n) 1 on the diagonal elsewhere."""

    @classmethod
    def at(cls, at_lower: Mask, at_upper: Mask) -> _ActiveSet:
        """From (n,) booleans."""
        lower, upper = at_lower.astype(float), (at_upper & ~at_lower).astype(float)
        free = 1.0 - lower - upper
        return cls(lower, upper, free, lower - upper, np.outer(free, free), np.diag(1.0 - free))


class Solver:
    """PIQP with a warm start: the active set of the last QP is tried first.

    An interior-point method cannot start from the last solution. But from one period to the next
    the active set rarely changes, and when it is known the rest is one linear system, whose
    solution is exact. So it is guessed, from the last QP or from PIQP's answer, and the guess is
    corrected by block pivoting (Júdice and Pires, 1994) until the conditions of optimality hold.
    If they do not within a few pivots, PIQP's own answer is the result.

    Args:
        precision: of PIQP's solution, absolute and relative.
    """

    def __init__(self, precision: float = HIGH_PRECISION) -> None:
        self._precision = precision
        self._active: _ActiveSet | None = None
        self._reset_piqp()

    def _reset_piqp(self) -> None:
        self._piqp = piqp.DenseSolver()
        settings = self._piqp.settings
        settings.eps_abs = settings.eps_rel = self._precision
        settings.check_duality_gap = True
        settings.eps_duality_gap_abs = settings.eps_duality_gap_rel = self._precision
        self._ready = False

    def solve(self, qp: QP) -> Array | None:
        """The minimiser (n,), inside the bounds to the last bit; None if there is none."""
        if self._active is not None and len(self._active.free) == len(qp.c):
            x = self._pivot(qp, self._active)
            if x is not None:
                return x
        solved = self._solve_with_piqp(qp)
        if not solved:
            # A new workspace is scaled for this QP; an updated one keeps the scaling of its first.
            self._reset_piqp()
            solved = self._solve_with_piqp(qp)
        P, c, lower, upper = qp
        rough: Array = np.minimum(np.maximum(self._piqp.result.x, lower), upper)
        if not np.isfinite(rough.sum()):
            rough = np.minimum(np.maximum(0.0, lower), upper)
        gradient = P @ rough + c
        guess = _ActiveSet.at(rough - lower < gradient, upper - rough < -gradient)
        exact = self._pivot(qp, guess, _FINAL_PIVOTS)
        return rough if exact is None and solved else exact

    def _pivot(self, qp: QP, active: _ActiveSet, pivots: int = _PIVOTS) -> Array | None:
        """The exact minimiser from a guess of the active set; None if it is not found."""
        P, c, lower, upper = qp
        for _ in range(pivots):
            held = lower * active.at_lower + upper * active.at_upper
            reduced = eigenpy.LLT(P * active.mask + active.identity)
            x: Array = reduced.solve(held - active.free * (c + P @ held))
            gradient = P @ x + c
            multipliers = gradient * active.sign
            excess = max((lower - x).max(), (x - upper).max())
            if excess <= _BOUND_TOLERANCE and multipliers.min() >= 0.0:
                self._active = active
                return np.minimum(np.maximum(x, lower), upper)
            kept = multipliers >= 0.0
            active = _ActiveSet.at(
                (active.at_lower > 0.0) & kept | (x < lower - _BOUND_TOLERANCE),
                (active.at_upper > 0.0) & kept | (x > upper + _BOUND_TOLERANCE),
            )
        return None

    def _solve_with_piqp(self, qp: QP) -> bool:
        P, c, lower, upper = qp
        # P is symmetric: its transpose is the column-major matrix that PIQP wants, without a copy.
        data = {"P": P.T, "c": c, "x_l": lower - _WIDENING, "x_u": upper + _WIDENING}
        if self._ready:
            self._piqp.update(**data)
        else:
            self._piqp.setup(**data)
            self._ready = True
        return bool(self._piqp.solve() == piqp.PIQP_SOLVED)

    def solve_soft(self, qp: QP, rows: Array, least: Array, weight: float) -> Array | None:
        """The same with soft bounds rows @ x >= least: passing them costs, so a solution exists.

        A row that the minimiser passes joins the cost as ½ w (row x - least)², and again, until no
        other row is passed.

        Args:
            qp: cost and box bounds.
            rows: (m, n).
            least: (m,).
            weight: w.
        """
        x = self.solve(qp)
        passed = np.zeros(len(rows), bool)
        for _ in range(_SOFT_SOLVES):
            if x is None or not (new := (rows @ x < least - _SOFT_TOLERANCE) & ~passed).any():
                break
            passed |= new
            A = rows[passed]
            x = self.solve(
                qp._replace(P=qp.P + weight * (A.T @ A), c=qp.c - weight * (least[passed] @ A))
            )
        return x
