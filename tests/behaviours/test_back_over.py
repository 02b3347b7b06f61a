"""A hand that strays on its way down comes back before it goes on."""

import numpy as np
import pytest
from harness import Harness, looking_down
from pinocchio import SE3

from behaviours.motion import over_grasp


@pytest.mark.parametrize(
    ("aside", "above", "goes_to"),
    [(0.005, 0.08, 0.0), (0.028, 0.08, 0.08), (0.028, 0.01, 0.0)],
)
def test_a_hand_that_has_strayed_comes_back_at_its_height(aside, above, goes_to):
    harness = Harness()
    harness.reach_over(looking_down(0.65, 0.0, 0.6))
    harness.run_for(None, 0.01)
    hand = harness.context.wTe
    wTg = hand * SE3(np.eye(3), np.array([aside, 0.0, above]))
    went = wTg.actInv(over_grasp(wTg, harness.context).translation)
    np.testing.assert_allclose(went, [0.0, 0.0, -goes_to], atol=1e-9)
