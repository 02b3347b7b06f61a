"""A queue to a writer on another thread."""

import threading
from collections.abc import Sequence

import pytest

from app.live.feed import Feed


class Stalled:
    """A writer that waits until it is let go."""

    def __init__(self) -> None:
        self.written: list[int] = []
        self.began = threading.Event()
        self.go = threading.Event()

    def __call__(self, batch: Sequence[int]) -> None:
        self.began.set()
        self.go.wait(60.0)
        self.written += batch


def test_a_robot_never_waits_and_loses_the_oldest() -> None:
    writer = Stalled()
    feed: Feed[int] = Feed(writer, lossless=False, capacity=10, batch=1)
    feed.put(0)
    assert writer.began.wait(60.0)
    for item in range(1, 101):
        feed.put(item)
    assert feed.dropped == 90
    writer.go.set()
    assert feed.close(60.0)
    assert writer.written == [0, *range(91, 101)]


def test_a_simulation_waits_and_loses_nothing() -> None:
    writer = Stalled()
    feed: Feed[int] = Feed(writer, lossless=True, capacity=10, batch=1)
    put: list[int] = []

    def simulate() -> None:
        for item in range(100):
            feed.put(item)
            put.append(item)

    loop = threading.Thread(target=simulate)
    loop.start()
    assert writer.began.wait(60.0)
    loop.join(0.2)
    assert loop.is_alive(), "the loop waits for the writer"
    assert len(put) <= 20
    writer.go.set()
    loop.join(60.0)
    assert feed.close(60.0)
    assert writer.written == list(range(100))
    assert feed.dropped == 0


@pytest.mark.parametrize("lossless", [True, False])
def test_a_writer_that_dies_stops_nobody(lossless: bool) -> None:
    calls: list[int] = []

    def write(batch: Sequence[int]) -> None:
        calls.append(len(batch))
        raise OSError("no space left")

    feed: Feed[int] = Feed(write, lossless=lossless, capacity=10, batch=2)
    for item in range(1000):
        feed.put(item)
    assert feed.close(60.0)
    assert str(feed.error) == "no space left"
    assert len(calls) == 1
