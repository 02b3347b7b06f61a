"""The times at which the watchdog acts, on a clock that the test turns on."""

from math import inf

import pytest

from hw import SIMULATION, Patience, Watchdog


class Loop:
    """A loop that stands still but for its feeds; the clock and the events of its watchdog."""

    def __init__(self, monkeypatch, patience: Patience | None, feeds=(), nap: float = 0.0) -> None:
        self.now, self.feeds, self.nap = 0.0, list(feeds), nap
        self.done: list[tuple[str, float]] = []
        monkeypatch.setattr("hw.loop_watchdog.stopwatch", lambda: self.now)
        monkeypatch.setattr(Watchdog, "_interrupt", lambda _: self.set("interrupt"))
        self.watchdog = Watchdog(lambda: None, lambda: self.set("abandon"), patience)
        self.watchdog._over = self.watchdog._stalled = self
        self.watchdog._watch()

    def set(self, what: str = "stop") -> None:
        """Something is done; without a word the thread is woken that stops the robot."""
        self.done.append((what, self.now))

    def wait(self, nap: float) -> bool:
        """The watchdog naps; whether all is over."""
        assert nap <= 0.02
        self.now += self.nap or nap
        if self.feeds and self.now >= self.feeds[0]:
            self.feeds.pop(0)
            self.watchdog.feed()
        return self.now > 100.0


def soon(what: str, time: float) -> tuple[str, object]:
    return what, pytest.approx(time + 0.01, abs=0.0101)


@pytest.mark.parametrize(
    ("patience", "stop", "interrupt", "abandon"),
    [
        (None, 0.18, 1.2, 4.0),
        (Patience(stop=0.05, interrupt=0.13, abandon=0.21), 0.05, 0.13, 0.21),
        (SIMULATION, inf, 60.0, 90.0),
    ],
)
def test_the_watchdog_acts_once_its_patience_ends(monkeypatch, patience, stop, interrupt, abandon):
    loop = Loop(monkeypatch, patience)
    times = [soon("stop", stop), soon("interrupt", interrupt), soon("abandon", abandon)]
    assert loop.done == times[stop == inf :]
    assert loop.watchdog.stalls == (stop < inf)


def test_every_stall_is_counted_from_the_last_feed(monkeypatch):
    patience = Patience(interrupt=inf, abandon=inf)
    loop = Loop(monkeypatch, patience, feeds=(0.1, 0.2, 0.7))
    assert loop.done == [soon("stop", 0.2 + 0.18), soon("stop", 0.7 + 0.18)]
    assert loop.watchdog.stalls == 2


def test_time_in_which_the_process_was_suspended_counts_as_a_tenth_of_a_second(monkeypatch):
    loop = Loop(monkeypatch, Patience(stop=0.15, interrupt=0.35, abandon=inf), nap=5.0)
    assert loop.done == [("stop", 10.0), ("interrupt", 20.0)]
