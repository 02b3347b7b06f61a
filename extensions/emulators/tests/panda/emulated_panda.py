"""An emulated Panda in a process of its own, at an address of its own."""

import json
import os
import subprocess
import sys
import time
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drivers.panda import missing

ROOT = Path(__file__).parents[4]
needs_library = pytest.mark.skipif(bool(missing()), reason=missing())
_numbers = count(1)


def _is_in_time() -> bool:
    """Whether the system lets the processes of driver and emulator run before all others."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    except OSError:
        return False
    return True


IN_TIME = _is_in_time()


def free_address() -> str:
    """One that no other test of this computer uses: the ports of the robot are fixed."""
    pid = os.getpid()
    return f"127.{1 + (pid >> 8) % 250}.{pid % 256}.{next(_numbers) % 250 + 1}"


MODULE = "extensions.emulators.panda"


class Emulator:
    """Runs `python -m extensions.emulators.panda`, and does things to it."""

    def __init__(self, reported: str) -> None:
        self.address = free_address()
        self.process = subprocess.Popen(
            [sys.executable, "-m", MODULE, self.address, "5", "-", reported],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])},
        )
        assert json.loads(self.process.stdout.readline()) == {"did": "begin"}
        if not IN_TIME:
            self.do("patience 1000")

    def do(self, words: str) -> dict[str, Any]:
        """Do something to the robot; what it tells then."""
        self.process.stdin.write(words + "\n")
        self.process.stdin.flush()
        told: dict[str, Any] = json.loads(self.process.stdout.readline())
        assert "error" not in told, told
        return told

    def tell(self) -> dict[str, Any]:
        """What it has seen."""
        return self.do("tell")

    def wait(self, done, patience: float = 60.0) -> dict[str, Any]:
        """Until it tells something."""
        until = time.monotonic() + patience
        while time.monotonic() < until:
            if done(told := self.tell()):
                return told
            time.sleep(0.005)
        raise AssertionError(f"not within {patience:g} s: {told}")


@contextmanager
def emulated(reported=""):
    emulator = Emulator(reported)
    try:
        yield emulator
    finally:
        emulator.process.stdin.close()
        emulator.process.wait(5.0)


@contextmanager
def connected(part):
    part.connect()
    try:
        yield part
    finally:
        part.close()


def drive(arm, seconds, speed=0.3):
    """Command the last joint to turn; the faults that are told meanwhile, each once."""
    seen, qd, begun = [], np.zeros(7), time.monotonic()
    qd[6] = speed
    while time.monotonic() < begun + seconds:
        arm.send(qd)
        seen += [fault for fault in arm.read().faults if fault not in seen]
        time.sleep(0.01)
    return seen
