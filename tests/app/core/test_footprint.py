"""The footprint sees what a process takes and gives back."""

import gc
from pathlib import Path
from threading import Event, Thread

import numpy as np

from app.core.footprint import footprint


def test_memory_threads_and_handles_are_counted(tmp_path: Path) -> None:
    gc.collect()  # what other tests left must not be let go in between
    before = footprint()
    taken = np.ones(8_000_000)  # 64 MB
    done = Event()
    thread = Thread(target=done.wait)
    thread.start()
    with (tmp_path / "open").open("w"):
        during = footprint()
    done.set()
    thread.join()
    after = footprint()

    assert during.rss - before.rss > 60e6
    assert during.threads == before.threads + 1
    assert during.handles == before.handles + 1
    assert (after.threads, after.handles) == (before.threads, before.handles)
    assert taken.size == 8_000_000
