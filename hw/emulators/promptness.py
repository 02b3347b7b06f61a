"""No real machine waits for what else a computer does."""

from __future__ import annotations

import gc
import os
from contextlib import suppress


def be_prompt(priority: int) -> None:
    """Ask for real-time priority, going on without it, and search no old memory any more."""
    with suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    gc.collect()
    gc.freeze()
