"""Simulated time goes where it is told, at the pace that a person can watch."""

import time

import pytest

from hw import SimClock, WallClock


def test_simulated_time_jumps_and_never_goes_back():
    clock = SimClock()
    clock.sleep_until(3600.0)
    assert clock.now() == 3600.0
    clock.sleep_until(10.0)
    assert clock.now() == 3600.0


def test_paced_time_is_not_ahead_of_the_computers_clock():
    clock = SimClock(pace=2.0)
    clock.sleep_until(0.0)
    begun = time.monotonic()
    clock.sleep_until(0.2)
    assert time.monotonic() - begun >= 0.09


def test_wall_time_sleeps_until_the_stamp_and_not_at_all_when_it_has_passed():
    clock = WallClock()
    clock.sleep_until(0.05)
    now = clock.now()
    assert now >= 0.05
    clock.sleep_until(now - 1.0)
    assert clock.now() == pytest.approx(now, abs=0.5)
