"""What holds for every test."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest


@pytest.fixture(autouse=True)
def same_priority() -> Iterator[None]:
    """No test leaves this process before all others: robots emulated for the next would be late.

    Libraries of real-time robots raise the priority of whoever calls them, and leave it so.
    """
    policy, priority = os.sched_getscheduler(0), os.sched_getparam(0)
    yield
    if (os.sched_getscheduler(0), os.sched_getparam(0)) != (policy, priority):
        os.sched_setscheduler(0, policy, priority)
