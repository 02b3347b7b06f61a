"""Interpolation of the readings of one part."""

import numpy as np
import pytest

from hw import ArmState
from hw.composition import History, _interpolate_arm


def reading(stamp, value):
    return ArmState(stamp=stamp, q=np.full(7, value), qd=np.zeros(7))


@pytest.fixture
def history():
    kept = History(_interpolate_arm)
    for number in range(6):
        kept.add(reading(0.1 * number, 10.0 * number))
    return kept


def value(history, stamp):
    return history.at(stamp).q[0]


def test_it_interpolates_inside_and_returns_the_nearest_reading_outside(history):
    assert value(history, 0.33) == pytest.approx(33.0)
    assert value(history, -1.0) == 0.0
    assert value(history, 9.0) == 50.0
    own = reading(0.6, 60.0)
    history.add(own)
    assert history.at(0.6) is own


def test_a_reading_of_the_same_or_an_earlier_stamp_replaces_later_ones(history):
    history.add(reading(0.5, 99.0))
    assert value(history, 0.5) == 99.0
    assert value(history, 0.45) == pytest.approx((40.0 + 99.0) / 2)
    history.add(reading(0.25, 25.0))
    assert value(history, 9.0) == 25.0
    assert value(history, 0.225) == pytest.approx(22.5)


def test_it_forgets_what_is_older_than_its_duration(history):
    history.add(reading(2.0, 7.0))
    assert value(history, 0.0) == 7.0
