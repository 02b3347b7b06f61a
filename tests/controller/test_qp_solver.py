"""QPs with rows, against solutions that were found another way."""

import numpy as np
import pytest
from scipy.optimize import minimize

from controller.qp_solver import MOST_ROWS, QP, Rows, Solver

N, GROUPS = 9, 6
COSTS = np.full(GROUPS, 1e3)


def random_qp(rng) -> QP:
    A = rng.normal(size=(N, N))
    lower = rng.uniform(-1.0, 0.0, N)
    return QP(A @ A.T + 0.1 * np.eye(N), rng.normal(size=N) * 3.0, lower, lower + rng.uniform(0, 2))


def random_rows(rng, qp, count, room) -> Rows:
    """Rows that a point within the bounds keeps by `room`, or misses if it is negative."""
    inside = rng.uniform(qp.lower, qp.upper)
    A = rng.normal(size=(count, N))
    return Rows(A, A @ inside - room, rng.integers(0, GROUPS, count))


def minimiser(qp, rows) -> np.ndarray:
    answer = minimize(
        lambda x: 0.5 * x @ qp.P @ x + qp.c @ x,
        np.clip(np.zeros(N), qp.lower, qp.upper),
        jac=lambda x: qp.P @ x + qp.c,
        bounds=list(zip(qp.lower, qp.upper, strict=True)),
        constraints={
            "type": "ineq",
            "fun": lambda x: rows.A @ x - rows.least,
            "jac": lambda x: rows.A,
        },
        method="SLSQP",
        options={"ftol": 1e-13, "maxiter": 500},
    )
    return answer.x if answer.success else None


@pytest.mark.parametrize("count", [1, 12])
def test_rows_are_hard_where_all_can_be_kept(count):
    rng, solver, bound = np.random.default_rng(count), Solver(COSTS), 0
    for _ in range(30):
        qp = random_qp(rng)
        rows = random_rows(rng, qp, count, room=0.05)
        x = solver.solve(qp, rows)
        assert (rows.A @ x >= rows.least - 1e-6).all()
        assert ((x >= qp.lower) & (x <= qp.upper)).all()
        if (expected := minimiser(qp, rows)) is not None:
            np.testing.assert_allclose(x, expected, atol=2e-5)
        bound += int((rows.A @ x < rows.least + 1e-6).any())
    assert bound > 10  # otherwise the rows were not tested


def test_rows_that_cannot_be_kept_are_passed_by_as_little_as_possible_and_spare_other_groups():
    rng, solver = np.random.default_rng(5), Solver(COSTS)
    for _ in range(30):
        qp = random_qp(rng)
        kept = random_rows(rng, qp, 4, room=0.2)
        direction = rng.normal(size=N)
        best = float(np.maximum(direction * qp.lower, direction * qp.upper).sum())
        rows = Rows(
            np.vstack([kept.A, direction]),
            np.append(kept.least, best + 0.3),
            np.array([0, 0, 1, 1, 2]),
        )
        x = solver.solve(qp, rows)
        assert ((x >= qp.lower) & (x <= qp.upper)).all()
        # What the lone row may cost the others is bounded by what a slack costs them all.
        passed = rows.least - rows.A @ x
        assert passed[4] >= 0.3 - 1e-6
        alone = solver.solve(qp, Rows(rows.A[4:], rows.least[4:], rows.group[4:]))
        assert rows.A[4] @ alone == pytest.approx(best, abs=5e-3)


def test_the_rows_in_most_danger_are_kept_where_there_are_too_many():
    rng, solver = np.random.default_rng(7), Solver(COSTS)
    qp = random_qp(rng)
    rows = random_rows(rng, qp, 3 * MOST_ROWS, room=0.5)
    x = solver.solve(qp, rows)
    free = solver.solve(qp)
    before, after = rows.A @ free - rows.least, rows.A @ x - rows.least
    assert before.min() < -0.1
    assert after[np.argsort(before)[:MOST_ROWS]].min() > -1e-6


def test_bounds_that_coincide_leave_no_choice():
    qp = QP(np.eye(N), np.ones(N), np.full(N, 0.25), np.full(N, 0.25))
    np.testing.assert_array_equal(Solver(COSTS).solve(qp), qp.lower)


def test_the_minimiser_within_bounds_fulfils_the_conditions_of_karush_kuhn_and_tucker():
    """Badly scaled ones too, in a few of which the active set goes round in circles."""
    rng, solver = np.random.default_rng(0), Solver(COSTS)
    for _ in range(4000):
        n = int(rng.integers(2, 10))
        A = rng.normal(size=(n, n)) * 10.0 ** rng.uniform(-2.0, 1.0, n)
        P = A @ A.T + 10.0 ** rng.uniform(-4.0, -1.0) * np.eye(n)
        c = rng.normal(size=n) * 10.0 ** rng.uniform(-1.0, 1.0)
        qp = QP(P, c, -rng.uniform(0.0, 1.0, n), rng.uniform(0.0, 1.0, n))
        x = solver.solve(qp)
        pull = P @ x + c
        assert ((qp.lower <= x) & (x <= qp.upper)).all()
        stepped = np.clip(x - pull / np.diag(P), qp.lower, qp.upper)
        assert np.abs(stepped - x).max() < 1e-4, (P, c)
