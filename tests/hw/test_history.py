"""Where a part was at a moment in between."""

from typing import NamedTuple

import pytest

from hw.history import History


class Reading(NamedTuple):
    stamp: float
    value: float


def between(a: Reading, b: Reading, stamp: float) -> Reading:
    share = (stamp - a.stamp) / (b.stamp - a.stamp)
    return Reading(stamp, a.value + share * (b.value - a.value))


@pytest.fixture
def history() -> History[Reading]:
    kept: History[Reading] = History(between, duration=0.5)
    for number in range(6):
        kept.add(Reading(0.1 * number, 10.0 * number))
    return kept


def test_a_moment_in_between_is_interpolated(history):
    assert history.at(0.33).value == pytest.approx(33.0)


def test_a_reading_at_its_own_stamp_is_returned_untouched(history):
    reading = Reading(0.6, 60.0)
    history.add(reading)
    assert history.at(0.6) is reading


def test_outside_of_the_history_the_nearest_reading_counts(history):
    assert history.at(-1.0).value == 0.0
    assert history.at(9.0).value == 50.0


def test_a_newer_reading_of_the_same_stamp_replaces_the_old_one(history):
    history.add(Reading(0.5, 99.0))
    assert history.at(0.5).value == 99.0
    assert history.at(0.45).value == pytest.approx((40.0 + 99.0) / 2)


def test_a_clock_that_steps_back_does_not_disorder_it(history):
    history.add(Reading(0.25, 25.0))
    assert history.at(9.0).value == 25.0
    assert history.at(0.225).value == pytest.approx(22.5)


def test_it_forgets_what_is_older_than_its_duration(history):
    history.add(Reading(2.0, 0.0))
    assert history.at(0.0) == Reading(2.0, 0.0)
