"""First contacts of a moving shape."""

import numpy as np
import pytest
from pinocchio import SE3, exp3

from hw.sim.contact import travel
from robots import Box, Geom

DOWN = np.array([0.0, 0.0, -1.0])
TABLE = Geom(Box((0.4, 0.4, 0.25)), SE3(np.eye(3), np.array([0.8, 0.0, 0.25])), "table")
HALF = (0.02, 0.03, 0.025)


def fall(x: float, y: float, height: float, turn: np.ndarray) -> float | None:
    """Of a block from a height over the table, turned by a rotation vector (3,)."""
    here = SE3(exp3(turn), np.array([x, y, 0.5 + HALF[2] + height]))
    return travel(Geom(Box(HALF), here), DOWN, [TABLE], 1.0)


def test_a_block_that_falls_on_a_table_stops_on_it_however_its_numbers_are_rounded():
    rng = np.random.default_rng(0)
    for _ in range(300):
        x, y, height = rng.uniform((0.5, -0.3, 0.01), (1.1, 0.3, 0.4))
        turn = rng.choice([0.0, 1e-12, 1e-5]) * rng.normal(size=3)
        assert fall(x, y, height, turn) == pytest.approx(height, abs=1e-4)


def test_a_block_beside_the_table_falls_past_it():
    assert fall(0.37, 0.0, 0.2, np.zeros(3)) is None
