"""What a computer has for drivers: libraries, and time."""

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

_NAPS, _NAP = 1000, 0.001
"""Of the loop that measures the computer [s]."""
_LATE = 20.0
"""The arm stops when commands are late for so long [ms]."""


def installed() -> Iterator[Finding]:
    """The libraries of the vendors."""
    for package, what in (("panda-python", "arm and hand"), ("pyrealsense2", "camera")):
        try:
            yield Finding("installed", Verdict.GOOD, f"{package} {version(package)} ({what})")
        except PackageNotFoundError:
            hint = 'pip install "frankie-task[hardware]"'
            yield Finding("installed", Verdict.BAD, f"{package} is missing ({what}): {hint}")


def computer() -> Iterator[Finding]:
    """Whether a loop of 1 kHz gets its time."""
    allowed = _may_hurry()
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
    late = _lateness()
    text = f"a loop of 1 ms is late by {late[0]:.2f} ms in the middle, {late[1]:.1f} ms at worst"
    yield Finding("computer", Verdict.GOOD if late[1] < _LATE else Verdict.BAD, text)


def is_realtime_kernel(flag: Path = Path("/sys/kernel/realtime")) -> bool:
    """Whether the kernel is PREEMPT_RT: patched ones have a flag, mainline ones say so."""
    is_patched = flag.is_file() and flag.read_text().strip() == "1"
    return is_patched or "PREEMPT_RT" in os.uname().version.replace(" ", "_")


def _may_hurry() -> bool:
    """Whether a thread gets real-time priority; tried in one of its own."""
    granted: list[bool] = []

    def ask() -> None:
        with suppress(OSError):
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
            granted.append(True)

    thread = threading.Thread(target=ask)
    thread.start()
    thread.join()
    return bool(granted)


def _lateness() -> tuple[float, float]:
    """How late a loop wakes, as the processes of the drivers do: median and worst [ms]."""
    late = []

    def nap() -> None:
        with suppress(OSError):
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
        for _ in range(_NAPS):
            due = stopwatch() + _NAP
            time.sleep(_NAP)
            late.append(1000.0 * (stopwatch() - due))

    thread = threading.Thread(target=nap)
    thread.start()
    thread.join()
    return float(np.median(late)), max(late)
