"""Candidates without a network."""

import numpy as np
import pytest

from perception.grasps.candidates import RandomPoints, SpreadPoints

ALLOWED = np.zeros((300, 300), dtype=bool)
ALLOWED[100:160, 50:90] = True
IMAGE = np.zeros((300, 300), dtype=np.float32)


@pytest.mark.parametrize("source", [RandomPoints(), SpreadPoints()])
def test_points_lie_where_a_grasp_may_be_and_are_the_same_again(source) -> None:
    one, again = (source.propose(IMAGE, ALLOWED).candidates for _ in range(2))
    assert (one.pixel == again.pixel).all()
    u, v = one.pixel.astype(int).T
    assert ALLOWED[v, u].all()
    assert len(np.unique(one.pixel, axis=0)) == len(u)
    assert (one.quality == 1.0).all()
