"""Joints that follow late are led by as much, and no further."""

from __future__ import annotations

import numpy as np
import pytest

from hw.panda import LIMITS
from hw.panda.arm import Lead

PERIOD = 0.01
QDD = np.array(LIMITS.qdd)


def led(lead: Lead, *speeds: float) -> list[float]:
    """What joint 1 is commanded, at 100 Hz."""
    return [lead.of(v * np.eye(7)[0], tick * PERIOD)[0] for tick, v in enumerate(speeds)]


def test_a_slope_is_led_by_the_lag_and_by_no_more_than_the_arm_can_accelerate():
    assert led(Lead(0.0, QDD), 0.1, 0.2, 0.0, -0.3) == [0.1, 0.2, 0.0, -0.3]
    lead = Lead(0.03, QDD)
    assert led(lead, 0.1, 0.12, 0.14, 0.0) == pytest.approx([0.1, 0.18, 0.2, 0.0])
    assert lead.of(0.3 * np.eye(7)[0], 1.0)[0] == 0.3  # after a pause
    assert led(Lead(0.03, QDD), 0.1, 9.0)[1] == pytest.approx(9.0 + 0.03 * QDD[0])
    assert lead.of(0.4 * np.eye(7)[0], 1.0 + 1e-6)[0] == pytest.approx(0.4 + 0.03 * 10.0)
