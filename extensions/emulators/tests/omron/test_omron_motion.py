"""What becomes of a velocity: ratios, what the base makes of them, and limits on random streams."""

from math import radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.omron.commander import ACCELERATIONS, Commander
from drivers.omron.site import REST, Ratios, Site, Velocity
from extensions.emulators.omron.onboard_controller import Controller, Teleop

RATIOS = [
    ((9, 4, 100), (0.0, 0.0)),
    ((10, 5, 100), (0.0, 2.5)),
    ((10.1, 4.99, 100), (0.101, 0.0)),
    ((100, 100, 5), (0.05, 2.5)),
    ((-100, 0, 100), (-0.25, 0.0)),
    ((-50, 50, 50), (-0.0625, 12.5)),
    ((0, 100, 100), (0.0, 50.0)),
]
"""Measured on the reference server: translation, rotation, throttle [%] to v, w [m/s, deg/s], from
rest, with turning at full speed as at rest."""

AT_REST_AS_AT_SPEED = {"turn_forwards": radians(50.0), "turn_backwards": radians(50.0)}
TURN_DEPENDS = Site(turn_at_forward_deg=25.0, turn_at_reverse_deg=25.0)
velocities = st.builds(Velocity, st.floats(-3.0, 3.0), st.floats(-4.0, 4.0))


class Bench:
    """Wheels in simulated time."""

    def __init__(self) -> None:
        self.v = self.w = 0.0

    def command(self, v: float, w: float) -> None:
        self.v, self.w = v, w

    def pose(self) -> tuple[float, float, float]:
        return (0.0, 0.0, 0.0)

    def twist(self) -> tuple[float, float]:
        return (self.v, self.w)


@pytest.mark.parametrize(("ratios", "velocity"), RATIOS)
def test_driver_and_emulator_know_the_measured_table(ratios, velocity):
    v, w = velocity
    if ratios[2] == 100:  # as the driver sends it
        assert Site().velocity(Ratios(*ratios[:2]), 0.0) == pytest.approx((v, radians(w)))
    controller = Controller(Bench(), Teleop(**AT_REST_AS_AT_SPEED))
    controller.ratio_drive(*ratios, 0.0)
    controller.step(0.1)
    assert controller.wanted == pytest.approx((v, radians(w)))


@given(velocities, st.floats(-0.25, 1.0), st.sampled_from([Site(), TURN_DEPENDS]))
@settings(derandomize=True, deadline=None, max_examples=80)
def test_what_the_base_makes_of_the_ratios_is_what_was_wanted(wanted, measured, site):
    reached = site.saturate(wanted, measured)
    assert abs(reached.v * wanted.w - reached.w * wanted.v) < 1e-9  # along the same arc
    ratios = site.ratios(reached, measured)
    assert all(abs(one) <= 100.0 for one in ratios)
    made = site.velocity(ratios, measured)
    for of, full, share in ((0, (0.25, 1.0)[reached.v > 0], 0.1), (1, radians(50), 0.05)):
        lost = made[of] == 0.0 and abs(ratios[of]) <= 100.0 * share + 1e-9
        assert made[of] == pytest.approx(reached[of], abs=1e-6) or lost, (full, ratios)


SLOW = [(0.03, 0.0), (-0.01, 0.0), (0.0, 0.01), (0.08, -0.01), (0.5, 0.01)]


@pytest.mark.parametrize("site", [Site(), Site(dead_translation=0.0, dead_rotation=0.0)])
@pytest.mark.parametrize("wanted", SLOW)
def test_slow_velocities_are_driven_in_pulses_that_go_as_far(wanted, site):
    it = Commander(site)
    way, peak, seconds = np.zeros(2), np.zeros(2), 40.0
    for step in range(int(seconds / 0.025)):
        now = 0.025 * step
        it.command(Velocity(*wanted), now)
        order = it.order(now, REST, may_move=True)
        made = np.array(site.velocity(order, 0.0))
        way, peak = way + 0.025 * made, np.maximum(peak, abs(made))
    least = site.least(Velocity(*wanted))
    assert way / seconds == pytest.approx(wanted, rel=0.1, abs=1e-9)
    assert (peak <= np.maximum(np.abs(wanted), least) + 1e-9).all()


def test_an_old_command_becomes_zero_then_a_stop_then_nothing():
    it, moving = Commander(Site()), Velocity(0.3, 0.0)
    assert it.order(5.0, Velocity(0.5, 0.0), may_move=True) is None
    it.command(moving, 10.0)
    assert it.order(10.0, REST, may_move=True).translation > 0.0
    assert it.order(10.09, moving, may_move=True).translation > 0.0
    assert it.order(10.11, moving, may_move=True) == (0.0, 0.0)
    assert it.order(10.19, moving, may_move=True) == (0.0, 0.0)
    assert it.order(10.21, moving, may_move=True) == "stop"
    assert it.order(10.23, moving, may_move=True) is None
    assert it.order(10.32, moving, may_move=True) == "stop"
    assert it.order(10.43, REST, may_move=True) is None
    assert it.is_idle
    it.command(moving, 11.0)
    assert it.order(11.0, REST, may_move=True).translation > 0.0
    assert it.order(11.02, REST, may_move=False) == "stop"


def test_a_velocity_from_before_the_stop_does_not_end_it():
    it = Commander(Site())
    it.command(Velocity(0.3, 0.0), 1.0)
    it.order(1.0, REST, may_move=True)
    it.stop()
    assert it.order(1.02, REST, may_move=True, measured_at=1.0) == "stop"
    assert it.order(1.15, REST, may_move=True, measured_at=1.0) == "stop"
    assert it.order(1.30, REST, may_move=True, measured_at=1.2) is None
    assert it.is_idle


@pytest.mark.parametrize("looks", [True, False])
def test_after_a_long_pause_the_velocity_begins_at_zero_again(looks):
    """A process that was suspended does not lurch, whether or not it sees its old command first."""
    it = Commander(Site())
    for step in range(200):
        it.command(Velocity(1.0, 0.0), step / 100)
        it.order(step / 100, REST, may_move=True)
    assert it.commanded == pytest.approx((1.0, 0.0), abs=0.01)
    if looks:
        assert it.order(62.0, Velocity(0.8, 0.0), may_move=True) == "stop"
    it.command(Velocity(1.0, 0.0), 62.1)
    assert abs(it.order(62.1, Velocity(0.4, 0.0), may_move=True).translation) < 11.0


def run_stream(rng: np.random.Generator) -> None:
    """Random commands at random times, judged by what the emulated base makes of them."""
    it, wheels = Commander(Site()), Bench()
    controller = Controller(wheels, Teleop(**AT_REST_AS_AT_SPEED))
    site, now, given_at, before = Site(), 0.0, -1.0, (0.0, 0.0)
    for _ in range(int(rng.integers(20, 60))):
        now += float(rng.choice((0.0, 0.01, 0.025, 0.025, 0.05, 0.3)))
        if rng.random() < 0.7:
            wanted = Velocity(*(rng.normal(size=2) * rng.choice((0.05, 0.5, 5.0))).tolist())
            it.command(site.saturate(wanted, wheels.v), now)
            given_at = now
        order = it.order(now, Velocity(*wheels.twist()), may_move=rng.random() < 0.98)
        told = site.velocity(order, wheels.v) if isinstance(order, Ratios) else REST
        for axis, pulse in enumerate(site.least(told)):
            same_way = told[axis] * before[axis] > 0.0
            growth = abs(told[axis]) - (abs(before[axis]) if same_way else 0.0)
            assert growth <= ACCELERATIONS[axis] * 0.05 + 1e-6 or abs(told[axis]) <= pulse + 1e-6
        if now - given_at > 0.1:
            assert told == REST
        if isinstance(order, Ratios):
            controller.ratio_drive(*order, 100.0, now)
            before = it.commanded
        else:
            before = (0.0, 0.0)
            if order == "stop":
                controller.stop()
        controller.step(now)
        assert -0.25 - 1e-6 <= controller.wanted[0] <= 1.0 + 1e-6
        assert abs(controller.wanted[1]) <= radians(50.0) + 1e-6
        assert -0.25 - 1e-6 <= wheels.v <= 1.0 + 1e-6
        assert abs(wheels.w) <= radians(50.0) + 1e-6


def test_random_commands_keep_the_limits_of_the_base():
    for seed in range(60):
        run_stream(np.random.default_rng(seed))
