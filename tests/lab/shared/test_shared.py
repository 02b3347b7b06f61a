"""Confidence intervals of shares, medians and paired differences; work that a signal ends."""

import os
import signal

import numpy as np
import pytest

from lab.shared import bootstrap, interval, paired_difference, run_all


def test_the_interval_of_a_share_is_that_of_the_textbook() -> None:
    assert interval([True] * 10 + [False] * 90) == pytest.approx((0.0552, 0.1744), abs=2e-4)


def test_the_interval_of_a_paired_difference() -> None:
    rng = np.random.default_rng(1)
    one = (rng.random(400) < 0.9).astype(float)
    assert paired_difference(one, one) == (0.0, 0.0, 0.0)
    worse = one.copy()
    worse[np.flatnonzero(one)[:40]] = 0.0
    mean, low, high = paired_difference(one, worse)
    assert mean == pytest.approx(0.1)
    # Of 40 in 400 by the binomial distribution.
    assert (low, high) == pytest.approx((0.1 - 0.0294, 0.1 + 0.0294), abs=0.004)
    mean, low, high = paired_difference(one, (rng.random(400) < 0.9).astype(float))
    assert low < 0.0 < high
    per_attempt = paired_difference(one, one, (np.full(400, 1.0), np.full(400, 2.0)))
    assert per_attempt[0] == pytest.approx(one.mean() / 2.0)


def test_the_interval_of_a_median_contains_it_and_shrinks() -> None:
    rng = np.random.default_rng(1)
    widths = []
    for count in (20, 500):
        values = list(rng.normal(1.0, 0.1, count))
        low, high = bootstrap(values, np.median, 1000)
        assert low <= np.median(values) <= high
        widths.append(high - low)
    assert widths[1] < widths[0]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_no_work_begins_after_a_signal_that_the_work_before_has_handled(number: int) -> None:
    begun = []

    def work(item: int) -> int:
        begun.append(item)
        before = signal.signal(number, lambda *_: None)
        os.kill(os.getpid(), number)
        signal.signal(number, before)
        return item

    with pytest.raises(KeyboardInterrupt):
        list(run_all(work, [1, 2]))
    assert begun == [1]
