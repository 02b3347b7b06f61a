"""Quadratic programmes over box bounds, and PIQP to solve them."""

from __future__ import annotations

from typing import NamedTuple

import eigenpy
import numpy as np
import numpy.typing as npt
import piqp

from controller.command import Array

Mask = npt.NDArray[np.bool_]

_FIRMNESS = 1e4
"""Cost of passing a soft bound, against weights of 1 to 200 in the rest of the cost."""
_PASSES = 3
_EXACT = 1e-12
"""What counts as inside the bounds where a linear system was solved."""
_ROUNDS = 4
"""Guesses of the active bounds that are corrected before PIQP is asked ..."""
_LAST_ROUNDS = 20
"""... and after it has answered, well or not."""
_ROOM = 1e-8
"""The bounds are this much wider for PIQP: where they coincide it has no interior to work in."""
PRECISE = 1e-10
"""A coarser solution would save no iterations worth having."""
ROUGH = 1e-7
"""As much as soft bounds allow: their price spreads the numbers over many orders of magnitude."""


class QP(NamedTuple):
    """A strictly convex quadratic qp over box bounds: min ½ xᵀ P x + cᵀ x."""

    P: Array
    """(n, n) symmetric, positive definite."""
    c: Array
    """(n,)."""
    lower: Array
    """(n,)."""
    upper: Array
    """(n,)."""


class _Active(NamedTuple):
    """Which bounds are active, as factors of 0 and 1 that make the reduced system out of P."""

    at_lower: Array
    """(n,)."""
    at_upper: Array
    """(n,)."""
    free: Array
    """(n,)."""
    inwards: Array
    """(n,) times the gradient is negative where an active bound deserves to be."""
    mask: Array
    """(n, n) 1 where row and column are free."""
    identity: Array
    """(n, n) 1 on the diagonal of what is not."""

    @classmethod
    def at(cls, at_lower: Mask, at_upper: Mask) -> _Active:
        """From (n,) booleans."""
        lower, upper = at_lower.astype(float), (at_upper & ~at_lower).astype(float)
        free = 1.0 - lower - upper
        return cls(lower, upper, free, upper - lower, np.outer(free, free), np.diag(1.0 - free))


class Solver:
    """PIQP, warm-started: the bounds that were active in the last qp are tried first.

    An interior-point method cannot start from the last solution. But from one period to the next
    the active bounds rarely change, and when they are known the rest is one linear system, whose
    solution is exact. So they are guessed, from the last qp or from PIQP's answer, and the
    guess is corrected by block pivoting (Júdice and Pires, 1994) until the conditions of optimality
    hold. PIQP's own answer stands where they do not within a few rounds.

    Args:
        precision: of PIQP's solution, absolute and relative.
    """

    def __init__(self, precision: float = PRECISE) -> None:
        self._precision = precision
        self._active: _Active | None = None
        self._renew()

    def _renew(self) -> None:
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
        solved = self._attempt(qp)
        if not solved:
            # A new workspace is scaled for this very qp, which a kept one is not.
            self._renew()
            solved = self._attempt(qp)
        P, c, lower, upper = qp
        rough: Array = np.minimum(np.maximum(self._piqp.result.x, lower), upper)
        if not np.isfinite(rough.sum()):
            rough = np.minimum(np.maximum(0.0, lower), upper)
        gradient = P @ rough + c
        guess = _Active.at(rough - lower < gradient, upper - rough < -gradient)
        exact = self._pivot(qp, guess, _LAST_ROUNDS)
        return rough if exact is None and solved else exact

    def _pivot(self, qp: QP, active: _Active, rounds: int = _ROUNDS) -> Array | None:
        """The exact minimiser, from a guess of the active bounds; None if that leads nowhere."""
        P, c, lower, upper = qp
        for _ in range(rounds):
            held = lower * active.at_lower + upper * active.at_upper
            reduced = eigenpy.LLT(P * active.mask + active.identity)
            x: Array = reduced.solve(held - active.free * (c + P @ held))
            gradient = P @ x + c
            pushed = gradient * active.inwards
            if (lower - x).max() <= _EXACT and (x - upper).max() <= _EXACT and pushed.max() <= 0.0:
                self._active = active
                return np.minimum(np.maximum(x, lower), upper)
            kept = pushed <= 0.0
            active = _Active.at(
                (active.at_lower > 0.0) & kept | (x < lower - _EXACT),
                (active.at_upper > 0.0) & kept | (x > upper + _EXACT),
            )
        return None

    def _attempt(self, qp: QP) -> bool:
        P, c, lower, upper = qp
        # P is symmetric: its transpose is the column-major matrix that PIQP wants, without a copy.
        data = {"P": P.T, "c": c, "x_l": lower - _ROOM, "x_u": upper + _ROOM}
        if self._ready:
            self._piqp.update(**data)
        else:
            self._piqp.setup(**data)
            self._ready = True
        return bool(self._piqp.solve() == piqp.PIQP_SOLVED)

    def solve_soft(self, qp: QP, rows: Array, least: Array) -> Array | None:
        """The same with soft bounds rows @ x >= least, at a high price, so that it always exists.

        A row that the minimiser passes joins the cost as ½ w (row x - least)², and again, until no
        other row is passed.

        Args:
            qp: the rest.
            rows: (m, n).
            least: (m,).
        """
        x = self.solve(qp)
        passed = np.zeros(len(rows), bool)
        for _ in range(_PASSES):
            if x is None or not (new := (rows @ x < least - 1e-6) & ~passed).any():
                break
            passed |= new
            G = rows[passed]
            x = self.solve(
                qp._replace(
                    P=qp.P + _FIRMNESS * (G.T @ G),
                    c=qp.c - _FIRMNESS * (least[passed] @ G),
                )
            )
        return x
