"""Quadratic programmes over box bounds, and PIQP to solve them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import piqp

from controller.command import Array

_FIRMNESS = 1e4
"""Cost of passing a soft bound, against weights of 1 to 200 in the rest of the cost."""
_PASSES = 3
_ROOM = 1e-8
"""The bounds are this much wider for PIQP: where they coincide it has no interior to work in."""
PRECISE = 1e-10
"""A coarser solution would save no iterations worth having."""
ROUGH = 1e-7
"""As much as soft bounds allow: their price spreads the numbers over many orders of magnitude."""


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


class Solver:
    """PIQP with its workspace kept from one programme to the next of the same size.

    Args:
        precision: of the solution, absolute and relative.
    """

    def __init__(self, precision: float = PRECISE) -> None:
        self._precision = precision
        self._renew()

    def _renew(self) -> None:
        self._piqp = piqp.DenseSolver()
        settings = self._piqp.settings
        settings.eps_abs = settings.eps_rel = self._precision
        settings.check_duality_gap = True
        settings.eps_duality_gap_abs = settings.eps_duality_gap_rel = self._precision
        self._ready = False

    def solve(self, programme: Programme) -> Array | None:
        """The minimiser (n,), inside the bounds to the last bit; None if PIQP found none."""
        if not self._attempt(programme):
            # A new workspace is scaled for this very programme, which a kept one is not.
            self._renew()
            if not self._attempt(programme):
                return None
        x: Array = np.minimum(np.maximum(self._piqp.result.x, programme.lower), programme.upper)
        return x

    def _attempt(self, programme: Programme) -> bool:
        P, c, lower, upper = programme
        # P is symmetric: its transpose is the column-major matrix that PIQP wants, without a copy.
        data = {"P": P.T, "c": c, "x_l": lower - _ROOM, "x_u": upper + _ROOM}
        if self._ready:
            self._piqp.update(**data)
        else:
            self._piqp.setup(**data)
            self._ready = True
        return bool(self._piqp.solve() == piqp.PIQP_SOLVED)

    def solve_softly(self, programme: Programme, rows: Array, least: Array) -> Array | None:
        """The same with soft bounds rows @ x >= least, at a high price, so that it always exists.

        A row that the minimiser passes joins the cost as ½ w (row x - least)², and again, until no
        other row is passed.

        Args:
            programme: the rest.
            rows: (m, n).
            least: (m,).
        """
        x = self.solve(programme)
        passed = np.zeros(len(rows), bool)
        for _ in range(_PASSES):
            if x is None or not (new := (rows @ x < least - 1e-6) & ~passed).any():
                break
            passed |= new
            G = rows[passed]
            x = self.solve(
                programme._replace(
                    P=programme.P + _FIRMNESS * (G.T @ G),
                    c=programme.c - _FIRMNESS * (least[passed] @ G),
                )
            )
        return x
