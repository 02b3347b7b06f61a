"""What limits do to the QP: they narrow the bounds of the velocities, and add rows."""

from collections.abc import Callable
from math import inf
from typing import TypeAlias

import numpy as np

from config.arrays import Array
from controller.qp_solver import Rows, joined
from controller.situation import Situation
from controller.validation import GoalError, check_numbers

SLACK_COSTS = np.array([1e4, 1e4, 1e4, 1e4, 1e4, 1e3, 3e3, 1.5e3, 1.5e3, 1.5e3])
"""By `PairKind`, the last for every degree of freedom of the base: static obstacles have priority
over moving ones, and the prediction of moving obstacles over their present distance to the base."""
OTHER_COST = 1e3
"""The same of all other rows, which have the group after these."""


class Constraints:
    """lower <= q̇ <= upper and rows of one period, to which limits add; GoalError, as of `Cost`."""

    def __init__(self, lower: Array, upper: Array) -> None:
        self.lower, self.upper = lower, upper  # (n,) [m/s, rad/s]
        self.rows: Rows | None = None

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper (n,)."""
        return self.lower, self.upper

    def narrow(self, lower: Array, upper: Array) -> None:
        """Keep q̇ within these (n,) as well; where they exclude each other, near the older ones."""
        old, n = self.bounds, len(self.lower)
        check_numbers("the lower bounds of `narrow`", lower, n, least=-inf, most=inf)
        check_numbers("the upper bounds of `narrow`", upper, n, least=-inf, most=inf)
        if not (lower <= upper).all():
            raise GoalError(f"bounds of `narrow` must be lower <= upper, got {lower} and {upper}")
        self.lower, self.upper = np.clip(lower, *old), np.clip(upper, *old)

    def keep(self, A: Array, least: Array) -> None:
        """Keep A q̇ >= least, for A (m, n) and least (m,); violated where it is infeasible."""
        check_numbers("A of `keep`", A, "m", len(self.lower))
        check_numbers("the least of `keep`", least, len(A))
        self.add(Rows(A, least, np.full(len(least), len(SLACK_COSTS))))

    def add(self, rows: Rows | None) -> None:
        """Add rows."""
        self.rows = joined(self.rows, rows)


Limit: TypeAlias = Callable[[Constraints, Situation], None]
"""Adds its part of the constraints, of any goal."""
