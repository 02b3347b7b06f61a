"""Measurements of a run: durations, and the resources of the process."""

import subprocess
import sys

import numpy as np

from app.core.measurements import Durations


def test_quantiles_are_within_one_percent_in_bounded_memory():
    values = np.random.default_rng(0).lognormal(-8.0, 1.5, 50_000)
    durations = Durations()
    for value in values:
        durations.append(value)
    assert len(durations) == len(values)
    assert len(durations._counts) < 1000
    for share in (0.01, 0.5, 0.99):
        np.testing.assert_allclose(
            durations.quantile(share), np.quantile(values, share), rtol=0.011
        )
    assert Durations().quantile(0.5) == 0.0


ALONE = """
from threading import Event, Thread
from time import sleep
import numpy as np
from app.core.measurements import footprint

before = footprint()
taken = np.ones(8_000_000)  # 64 MB
done = Event()
thread = Thread(target=done.wait)
thread.start()
with open("open", "w"):
    during = footprint()
done.set()
thread.join()
for _ in range(200):  # the system forgets a thread a little after it was joined
    after = footprint()
    if after.threads == before.threads:
        break
    sleep(0.01)

assert taken.size == 8_000_000
assert during.rss - before.rss > 60e6, (before, during)
assert during.threads == before.threads + 1, (before, during)
assert during.handles == before.handles + 1, (before, during)
assert (after.threads, after.handles) == (before.threads, before.handles), (before, after)
"""
"""In a process of its own, in which nothing else comes and goes."""


def test_memory_threads_and_handles_are_counted(tmp_path) -> None:
    path = ":".join(entry for entry in sys.path if entry)
    command = [sys.executable, "-c", ALONE]
    run = subprocess.run(
        command, cwd=tmp_path, env={"PYTHONPATH": path}, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
