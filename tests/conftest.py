"""What holds for every test."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

REAL_TIME = [
    Path(__file__).parent / "hw" / name for name in ("hardware", "omron", "panda", "realsense")
]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Where an emulated robot runs in real time, a test has three attempts.

    A computer that stands still for 20 ms makes such a robot stop, as it should: that says nothing
    about the driver. A driver that is wrong is wrong three times.
    """
    for item in items:
        if any(folder in item.path.parents for folder in REAL_TIME):
            item.add_marker(pytest.mark.flaky(reruns=2))


@pytest.fixture(autouse=True)
def same_priority() -> Iterator[None]:
    """No test leaves this process before all others: robots emulated for the next would be late.

    Libraries of real-time robots raise the priority of whoever calls them, and leave it so.
    """
    policy, priority = os.sched_getscheduler(0), os.sched_getparam(0)
    yield
    if (os.sched_getscheduler(0), os.sched_getparam(0)) != (policy, priority):
        os.sched_setscheduler(0, policy, priority)
