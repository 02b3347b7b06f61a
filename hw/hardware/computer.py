"""Diagnostics of the computer: libraries, and real-time behaviour."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from hw.clock import stopwatch
from hw.hardware.findings import Finding, Verdict

_NAPS, _NAP = 1000, 0.001  # number and time of the sleeps that measure the computer [s]
_LATE = 20.0  # the arm stops when commands are this late [ms]


def installed() -> Iterator[Finding]:
    """Whether the vendors' libraries are installed."""
    for package, what in (("panda-python", "arm and hand"), ("pyrealsense2", "camera")):
        try:
            yield Finding("installed", Verdict.GOOD, f"{package} {version(package)} ({what})")
        except PackageNotFoundError:
            hint = 'pip install "frankie-task[hardware]"'
            yield Finding("installed", Verdict.BAD, f"{package} is missing ({what}): {hint}")


def computer() -> Iterator[Finding]:
    """Whether a 1 kHz loop is on time."""
    allowed, median, worst = _measure()
    hint = "" if allowed else ": `@realtime - rtprio 99` in /etc/security/limits.conf"
    text = f"real-time priority is {'granted' if allowed else 'refused'}{hint}"
    yield Finding("computer", Verdict.GOOD if allowed else Verdict.BAD, text)
    is_realtime = is_realtime_kernel()
    name = "a real-time kernel" if is_realtime else "no real-time kernel (PREEMPT_RT)"
    yield Finding("computer", Verdict.GOOD if is_realtime else Verdict.OPEN, name)
    governors = {
        path.read_text().strip()
        for path in Path("/sys/devices/system/cpu").glob("cpu[0-9]*/cpufreq/scaling_governor")
    }
    if governors:
        good = governors == {"performance"}
        text = f"clock governor: {', '.join(sorted(governors))}"
        hint = "" if good else "; `cpupower frequency-set -g performance`"
        yield Finding("computer", Verdict.GOOD if good else Verdict.BAD, text + hint)
    text = f"a loop of 1 ms is late by {median:.2f} ms in the middle, {worst:.1f} ms at worst"
    yield Finding("computer", Verdict.GOOD if worst < _LATE else Verdict.BAD, text)


def is_realtime_kernel(flag: Path = Path("/sys/kernel/realtime")) -> bool:
    """Whether the kernel is PREEMPT_RT: by its flag (patched) or version (mainline)."""
    is_patched = flag.is_file() and flag.read_text().strip() == "1"
    return is_patched or "PREEMPT_RT" in os.uname().version.replace(" ", "_")


def _measure() -> tuple[bool, float, float]:
    """Whether a thread gets real-time priority, and how late it wakes: median and worst [ms]."""
    granted, late = [False], []

    def measure() -> None:
        with suppress(OSError):
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
            granted[0] = True
        for _ in range(_NAPS):
            due = stopwatch() + _NAP
            time.sleep(_NAP)
            late.append(1000.0 * (stopwatch() - due))

    thread = threading.Thread(target=measure)
    thread.start()
    thread.join()
    return granted[0], float(np.median(late)), max(late)
