"""Quadratic programs (QPs) over box bounds and rows, solved by PIQP."""

from __future__ import annotations

from typing import Any, NamedTuple

import eigenpy
import numpy as np
import numpy.typing as npt
import piqp

from controller.command import Array

MOST_ROWS = 32
"""Rows in one QP; of more, those that are in most danger."""

_PRECISION = 1e-10
"""Of PIQP, absolute and relative; a coarser solution saves no iterations to speak of."""
_SOFT_PRECISION = 1e-6
"""The same with slack, whose weights spread the numbers over more orders of magnitude."""
_ROW_TOLERANCE = 1e-7
"""A row is kept if it is passed by no more than this."""
_WIDENING = 1e-8
"""The bounds are this much wider for PIQP: where they coincide there is no interior."""
_MOST_SLACK = 100.0
_ITERATIONS = 100
"""Of PIQP at most."""


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


class Rows(NamedTuple):
    """Further constraints A x >= least."""

    A: Array
    """(m, n)."""
    least: Array
    """(m,)."""
    group: npt.NDArray[np.int64]
    """(m,) numbers of their slack: where not all rows can be kept, the rows of a group are all
    passed by up to as much as one of them has to be."""


def joined(first: Rows | None, second: Rows | None) -> Rows | None:
    """All rows of both."""
    if first is None or second is None:
        return first or second
    return Rows(*(np.concatenate(both) for both in zip(first, second, strict=True)))


class Solver:
    """PIQP, with workspaces that are kept from period to period.

    Args:
        slack_costs: (g,) cost of the slack of each group of rows, and of half its square. What is
            large against the gradients of the other costs is only used where there is no way
            without; and where not all groups can be kept, the cheaper ones give way.
    """

    def __init__(self, slack_costs: Array) -> None:
        self._slack_costs = slack_costs
        self._box = _Workspace(_PRECISION)
        self._hard = _Workspace(_PRECISION)
        self._soft = _Workspace(_SOFT_PRECISION)

    def solve(self, qp: QP, rows: Rows | None = None) -> Array | None:
        """The minimiser (n,), inside the bounds to the last bit; None if none was found.

        Rows are hard where all of them can be kept. Elsewhere they are soft, the bounds are not.
        """
        x = self._solve_box(qp)
        if x is None or rows is None or (rows.A @ x >= rows.least - _ROW_TOLERANCE).all():
            return x
        if len(rows.least) > MOST_ROWS:
            rows = _in_most_danger(rows, x)
        # A single row that no velocity keeps says it without PIQP.
        best = np.maximum(rows.A * qp.lower, rows.A * qp.upper).sum(axis=1)
        if (best >= rows.least).all() and (kept := self._solve_hard(qp, rows)) is not None:
            return kept
        softened = self._solve_soft(qp, rows)
        return x if softened is None else softened

    def _solve_box(self, qp: QP) -> Array | None:
        free: Array = eigenpy.LLT(qp.P).solve(-qp.c)
        if ((free >= qp.lower) & (free <= qp.upper)).all():
            return free
        # P is symmetric: its transpose is the column-major matrix that PIQP wants, without a copy.
        lower, upper = qp.lower - _WIDENING, qp.upper + _WIDENING
        x = self._box.solve(P=qp.P.T, c=qp.c, x_l=lower, x_u=upper)
        return None if x is None else np.minimum(np.maximum(x, qp.lower), qp.upper)

    def _solve_hard(self, qp: QP, rows: Rows) -> Array | None:
        n, m = len(qp.c), len(rows.least)
        G, h = np.zeros((MOST_ROWS, n)), np.ones(MOST_ROWS)
        G[:m], h[:m] = -rows.A, -rows.least
        lower, upper = qp.lower - _WIDENING, qp.upper + _WIDENING
        x = self._hard.solve(P=qp.P.T, c=qp.c, G=G, h_u=h, x_l=lower, x_u=upper)
        return None if x is None else np.minimum(np.maximum(x, qp.lower), qp.upper)

    def _solve_soft(self, qp: QP, rows: Rows) -> Array | None:
        """With a slack t >= 0 for every group: A x + t >= least."""
        n, m, costs = len(qp.c), len(rows.least), self._slack_costs
        g = len(costs)
        P = np.zeros((n + g, n + g), order="F")
        P[:n, :n] = qp.P
        P[range(n, n + g), range(n, n + g)] = costs
        G, h = np.zeros((MOST_ROWS, n + g)), np.ones(MOST_ROWS)
        G[:m, :n], h[:m] = -rows.A, -rows.least
        G[np.arange(m), n + rows.group] = -1.0
        x = self._soft.solve(
            P=P,
            c=np.concatenate([qp.c, costs]),
            G=G,
            h_u=h,
            x_l=np.concatenate([qp.lower - _WIDENING, np.zeros(g)]),
            x_u=np.concatenate([qp.upper + _WIDENING, np.full(g, _MOST_SLACK)]),
        )
        return None if x is None else np.minimum(np.maximum(x[:n], qp.lower), qp.upper)


class _Workspace:
    """A solver of PIQP for problems of one size."""

    def __init__(self, precision: float) -> None:
        self._precision = precision
        self._n = 0

    def solve(self, **problem: Any) -> Array | None:
        """The minimiser; None if there is none."""
        if self._n != len(problem["c"]):
            self._set_up(problem)
        else:
            self._piqp.update(**problem)
        if self._piqp.solve() != piqp.PIQP_SOLVED:
            # A new workspace is scaled for this problem; one that is updated keeps the scaling of
            # its first.
            self._set_up(problem)
            if self._piqp.solve() != piqp.PIQP_SOLVED:
                return None
        x: Array = self._piqp.result.x
        return x

    def _set_up(self, problem: dict[str, Any]) -> None:
        self._piqp = piqp.DenseSolver()
        settings = self._piqp.settings
        settings.eps_abs = settings.eps_rel = self._precision
        settings.check_duality_gap = True
        settings.eps_duality_gap_abs = settings.eps_duality_gap_rel = self._precision
        settings.max_iter = _ITERATIONS
        self._piqp.setup(**problem)
        self._n = len(problem["c"])


def _in_most_danger(rows: Rows, x: Array) -> Rows:
    margin = rows.A @ x - rows.least
    chosen = np.sort(np.argsort(margin, kind="stable")[:MOST_ROWS])
    return Rows(rows.A[chosen], rows.least[chosen], rows.group[chosen])
