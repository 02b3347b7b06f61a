"""Quadratic programs (QPs) over box bounds and rows, solved by PIQP."""

from typing import Any, NamedTuple

import numpy as np
import piqp

from config.arrays import Array, Indices

MOST_ROWS = 32  # largest number of rows in one QP; of more, those with the least margin

_PRECISION = 1e-10  # absolute and relative tolerance of PIQP
_SOFT_PRECISION = 1e-6  # the same with slack variables, whose weights make the QP worse conditioned
_ROW_TOLERANCE = 1e-7  # violation up to which a row counts as satisfied
_WIDENING = 1e-8  # PIQP gets bounds this much wider: where they coincide there is no interior
_MOST_SLACK = 100.0
_MAX_ITERATIONS = 100
_MAX_CHANGES = 8  # of the set of variables that are at their bounds


class QP(NamedTuple):
    """A strictly convex QP over box bounds: min ½ xᵀ P x + cᵀ x, lower <= x <= upper."""

    P: Array  # (n, n) symmetric, positive definite
    c: Array  # (n,)
    lower: Array  # (n,)
    upper: Array  # (n,)


def nearest_to(x: Array, lower: Array, upper: Array) -> QP:
    """The QP whose minimiser within the bounds is nearest to x (n,)."""
    return QP(np.eye(len(x)), -x, lower, upper)


class Rows(NamedTuple):
    """Inequality constraints A x >= least."""

    A: Array  # (m, n)
    least: Array  # (m,)
    group: Indices  # (m,) index of their slack, which the rows of a group share


def joined(first: Rows | None, second: Rows | None) -> Rows | None:
    """The rows of both."""
    if first is None or second is None:
        return first or second
    return Rows(*(np.concatenate(both) for both in zip(first, second, strict=True)))


class Solver:
    """PIQP with hard rows where they are feasible together, else with soft ones.

    Args:
        slack_costs: (g,) linear and quadratic cost of the slack of each group of rows; exact
            penalties, so that slack is used only where the rows are infeasible.
    """

    def __init__(self, slack_costs: Array) -> None:
        from scipy.linalg import lapack  # imported here: only what moves a robot needs it

        self._lapack = lapack
        self._slack_costs = slack_costs
        self._box = _Workspace(_PRECISION)
        self._hard = _Workspace(_PRECISION)
        self._soft = _Workspace(_SOFT_PRECISION)

    def solve(self, qp: QP, rows: Rows | None = None) -> Array | None:
        """The minimiser (n,), exactly inside the bounds; None if none was found."""
        x = self._solve_box(qp)
        if x is None or rows is None or (rows.A @ x >= rows.least - _ROW_TOLERANCE).all():
            return x
        if len(rows.least) > MOST_ROWS:
            rows = _least_margin(rows, x)
        # A row that no x within the bounds satisfies is infeasible by itself.
        best = np.maximum(rows.A * qp.lower, rows.A * qp.upper).sum(axis=1)
        if (best >= rows.least).all() and (kept := self._solve_hard(qp, rows)) is not None:
            return kept
        softened = self._solve_soft(qp, rows)
        return x if softened is None else softened

    def _solve_box(self, qp: QP) -> Array | None:
        """By the primal-dual active set method (Hintermüller et al., 2003), else by PIQP.

        With the variables A fixed at their bounds b, x = f - P⁻¹_A μ, where f is the minimiser
        without bounds, P⁻¹_A are columns of P⁻¹, and the multipliers μ solve P⁻¹_AA μ = f_A - b.
        """
        cholesky, free, failed = self._lapack.dposv(qp.P, -qp.c)
        lower, upper = qp.lower.tolist(), qp.upper.tolist()
        x: Array = free
        fixed: dict[int, float] = {}
        kept: dict[int, float] = {}
        for _ in range(0 if failed else _MAX_CHANGES):
            places = enumerate(zip(x.tolist(), lower, upper, strict=True))
            fixes = {i: a if v < a else b for i, (v, a, b) in places if not a <= v <= b} | kept
            if fixes == fixed:
                return x
            if not fixes:  # that is where it began: it goes round in circles
                break
            fixed, some, bounds = fixes, list(fixes), list(fixes.values())
            columns = self._lapack.dpotrs(cholesky, np.eye(len(x)).take(some, 0).T)[0]
            missing = free.take(some) - bounds
            multipliers = self._lapack.dposv(columns.take(some, 0), missing)[1]
            x = free - columns @ multipliers
            x[some] = bounds
            pulls = zip(fixed.items(), multipliers.tolist(), strict=True)
            kept = {i: b for (i, b), pull in pulls if b == (upper if pull > 0.0 else lower)[i]}
        # P is symmetric: its transpose is the column-major matrix that PIQP wants, without a copy.
        lower, upper = qp.lower - _WIDENING, qp.upper + _WIDENING
        found = self._box.solve(P=qp.P.T, c=qp.c, x_l=lower, x_u=upper)
        return None if found is None else np.minimum(np.maximum(found, qp.lower), qp.upper)

    def _solve_hard(self, qp: QP, rows: Rows) -> Array | None:
        n, m = len(qp.c), len(rows.least)
        G, h = np.zeros((MOST_ROWS, n)), np.ones(MOST_ROWS)
        G[:m], h[:m] = -rows.A, -rows.least
        lower, upper = qp.lower - _WIDENING, qp.upper + _WIDENING
        x = self._hard.solve(P=qp.P.T, c=qp.c, G=G, h_u=h, x_l=lower, x_u=upper)
        return None if x is None else np.minimum(np.maximum(x, qp.lower), qp.upper)

    def _solve_soft(self, qp: QP, rows: Rows) -> Array | None:
        """With slack variables t >= 0 for the groups: A x + t >= least."""
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
    """A PIQP solver that is reused for problems of one size."""

    def __init__(self, precision: float) -> None:
        self._precision = precision
        self._n = 0

    def solve(self, **problem: Any) -> Array | None:
        if self._n != len(problem["c"]):
            self._set_up(problem)
        else:
            self._piqp.update(**problem)
        if self._piqp.solve() != piqp.PIQP_SOLVED:
            # An updated workspace keeps the scaling of its first problem; a new one is rescaled.
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
        settings.max_iter = _MAX_ITERATIONS
        self._piqp.setup(**problem)
        self._n = len(problem["c"])


def _least_margin(rows: Rows, x: Array) -> Rows:
    margin = rows.A @ x - rows.least
    chosen = np.sort(np.argsort(margin, kind="stable")[:MOST_ROWS])
    return Rows(rows.A[chosen], rows.least[chosen], rows.group[chosen])
