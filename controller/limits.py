"""What limits do to the QP: they narrow the bounds of the velocities, and add rows."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from config.arrays import Array
from controller.qp_solver import Rows, joined
from controller.situation import Situation

SLACK_COSTS = np.array([1e4, 1e4, 1e4, 1e4, 1e4, 1e3, 3e3, 1.5e3, 1.5e3, 1.5e3])
"""By `PairKind`, the last for every degree of freedom of the base: static obstacles have priority
over moving ones, and the prediction of moving obstacles over their present distance to the base."""
OTHER_COST = 1e3
"""The same of all other rows, which have the group after these."""


class Constraints:
    """lower <= q̇ <= upper and rows of one period, to which limits add."""

    def __init__(self, lower: Array, upper: Array) -> None:
        self.lower, self.upper = lower, upper  # (n,) [m/s, rad/s]
        self.rows: Rows | None = None

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper (n,)."""
        return self.lower, self.upper

    def narrow(self, lower: Array, upper: Array) -> None:
        """Keep q̇ within these (n,) as well; where they exclude each other, near the older ones."""
        old = self.bounds
        self.lower, self.upper = np.clip(lower, *old), np.clip(upper, *old)

    def keep(self, A: Array, least: Array) -> None:
        """Keep A q̇ >= least, for A (m, n) and least (m,); violated where it is infeasible."""
        self.add(Rows(A, least, np.full(len(least), len(SLACK_COSTS))))

    def add(self, rows: Rows | None) -> None:
        """Add rows."""
        self.rows = joined(self.rows, rows)


Limit: TypeAlias = Callable[[Constraints, Situation], None]
"""Adds its part of the constraints, of any goal."""
