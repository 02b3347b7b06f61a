"""Joints that follow late are led by as much, and no further."""

from __future__ import annotations

import numpy as np
import pytest
from emulated_panda import Emulator, needs_library

from hw import WallClock
from hw.panda import LIMITS, ArmSettings, PandaArm
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


@needs_library
@pytest.mark.slow  # timed: it wants a computer without other work
@pytest.mark.parametrize(
    ("lead", "frequency", "most"),
    [(0.0, 0.2, 0.05), (0.03, 0.2, 0.01), (0.03, 0.4, 0.015), (0.03, 1.0, 0.08)],
)
def test_velocities_are_tracked_within_5_percent(lead, frequency, most):
    """References at 100 Hz, joints that lag by 25 ms."""
    emulator = Emulator()
    clock = WallClock()
    arm = PandaArm(emulator.address, clock, ArmSettings(lead=lead))
    arm.connect()
    wanted, measured, begun = [], [], clock.now()

    def reference(t):
        return 0.3 * np.sin(2.0 * np.pi * frequency * t) * np.eye(7)[5]

    for tick in range(round(2.0 / frequency / PERIOD)):
        arm.send(reference(clock.now() - begun))
        clock.sleep_until(begun + (tick + 1) * PERIOD)
        state = arm.read()
        wanted.append(reference(state.stamp - begun)[5])
        measured.append(state.qd[5])
    told = emulator.tell()
    arm.close()
    emulator.close()
    error = np.sqrt(np.mean((np.array(measured) - wanted) ** 2) / np.mean(np.square(wanted)))
    print(f"lead {lead:g} s, {frequency:g} Hz: {100.0 * error:.2f} %")
    assert error < most, f"{100.0 * error:.2f} %"
    assert told["violations"] == []
