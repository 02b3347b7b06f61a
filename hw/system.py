"""What operating systems do differently: real-time priority, and the state of another process.

What only Linux has is a gain, never a need: everything here also runs without it.
"""

import os
from pathlib import Path


def has_priorities() -> bool:
    """Whether the operating system has real-time priorities, granted or not."""
    return hasattr(os, "sched_setscheduler")


def run_at(priority: int, *, inherited: bool = True) -> bool:
    """Run this thread at a real-time priority, 0 for none; whether the system grants it.

    Threads and processes that it starts later inherit the priority, or not.
    """
    if not has_priorities():
        return False
    policy = os.SCHED_FIFO if priority else os.SCHED_OTHER
    if not inherited:
        policy |= os.SCHED_RESET_ON_FORK
    try:
        os.sched_setscheduler(0, policy, os.sched_param(priority))
    except OSError:
        return False
    return True


def stat_of(pid: int) -> list[str]:
    """State, parent and further fields of a process, as Linux writes them; empty: unknown."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return []
