"""Waiting for what happens in real time."""

import time
from collections.abc import Callable


def until(done: Callable[[], object], patience: float = 60.0) -> float:
    """Wait for something; how long that took [s]."""
    begun = time.monotonic()
    while not done():
        assert time.monotonic() < begun + patience, f"not within {patience:g} s"
        time.sleep(0.002)
    return time.monotonic() - begun
