"""Findings of the diagnostics; those of the computer: libraries, and real-time behaviour."""

import os
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from config import extra
from hw.clock import stopwatch

_NAPS, _NAP = 1000, 0.001  # number and time of the sleeps that measure the computer [s]
_LATE = 20.0  # the arm stops when commands are this late [ms]


class Verdict(Enum):
    """Meaning of a finding."""

    GOOD = "good"
    BAD = "bad"
    OPEN = "open"  # not known, or to be decided by the user


@dataclass(frozen=True)
class Finding:
    """One finding."""

    about: str
    verdict: Verdict
    text: str


def is_good(about: str, good: bool, text: str) -> Finding:
    """A finding that is good or bad."""
    return Finding(about, Verdict.GOOD if good else Verdict.BAD, text)


def computer() -> Iterator[Finding]:
    """Whether the vendors' libraries are installed, and a 1 kHz loop is on time."""
    for package, what in (("panda-python", "arm and hand"), ("pyrealsense2", "camera")):
        try:
            yield Finding("installed", Verdict.GOOD, f"{package} {version(package)} ({what})")
        except PackageNotFoundError:
            told = f"{package} is missing ({what}): {extra('hardware')}"
            yield Finding("installed", Verdict.BAD, told)
    allowed, median, worst = _measure()
    hint = "" if allowed else ": `@realtime - rtprio 99` in /etc/security/limits.conf"
    text = f"real-time priority is {'granted' if allowed else 'refused'}{hint}"
    yield is_good("computer", allowed, text)
    if "PREEMPT_RT" in os.uname().version.replace(" ", "_"):
        yield Finding("computer", Verdict.GOOD, "a real-time kernel")
    else:
        yield Finding("computer", Verdict.OPEN, "no real-time kernel (PREEMPT_RT)")
    places = Path("/sys/devices/system/cpu").glob("cpu[0-9]*/cpufreq/scaling_governor")
    if governors := {path.read_text().strip() for path in places}:
        good = governors == {"performance"}
        text = f"clock governor: {', '.join(sorted(governors))}"
        hint = "" if good else "; `cpupower frequency-set -g performance`"
        yield is_good("computer", good, text + hint)
    text = f"a loop of 1 ms is late by {median:.2f} ms in the middle, {worst:.1f} ms at worst"
    yield is_good("computer", worst < _LATE, text)


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
