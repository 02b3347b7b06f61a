"""The driver or its guardian is killed or suspended; how soon the base is told to rest."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from emulated import SPEED, connected, drive, is_at_rest, set_off, told_to_rest, wait_for_fault
from waiting import until

from hw import FaultKind
from hw.clock import stopwatch
from hw.emulators.omron import OmronEmulator

pytestmark = pytest.mark.realtime

TOLD = 0.25
"""The base is told to rest within this time of the last good command [s]."""
SCRIPT = """
import sys, time
import numpy as np
from hw import WallClock
from hw.omron import OmronBase, OmronOptions
base = OmronBase(
    OmronOptions(address="127.0.0.1", port=int(sys.argv[1]), user="frankie"), WallClock()
)
base.connect()
print(base.link.guardian.pid, flush=True)
while True:
    base.read()
    base.send(np.array([0.15, 0.0, 0.0]))
    time.sleep(0.01)
"""


@contextmanager
def driving(emulator: OmronEmulator) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """A process that drives the emulated base, and the process that guards it."""
    command = [sys.executable, "-c", SCRIPT, str(emulator.port)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        guardian = int(process.stdout.readline())
        until(lambda: is_moving(emulator))
        yield process, guardian
    finally:
        process.kill()
        process.communicate()


def is_moving(emulator: OmronEmulator) -> bool:
    return emulator.controller.drive.twist()[0] > 0.8 * SPEED


def exists(pid: int) -> bool:
    """Whether a process is there and is no zombie."""
    try:
        return " Z " not in Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return False


def test_suspended_the_base_is_stopped_and_killed_it_is_stopped_too():
    with OmronEmulator() as emulator, driving(emulator) as (process, guardian):
        process.send_signal(signal.SIGSTOP)
        until(lambda: is_at_rest(emulator) and emulator.heard[-1].name == "stop")
        before = len(emulator.heard)
        process.send_signal(signal.SIGCONT)
        until(lambda: is_moving(emulator))  # its commands are fresh again
        ratios = [one.values for one in list(emulator.heard)[before:] if not one.is_zero]
        assert ratios[0][0] <= 10.5  # it begins slowly: by a pulse
        process.kill()
        until(lambda: is_at_rest(emulator) and emulator.heard[-1].name == "stop")
        until(lambda: not exists(guardian) and not emulator.clients)


def test_without_its_guardian_the_driver_does_not_go_on():
    with OmronEmulator() as emulator, connected(emulator) as base:
        set_off(emulator, base)
        os.kill(base.link.guardian.pid, signal.SIGKILL)
        wait_for_fault(base, FaultKind.CONNECTION, "guards it")
        until(lambda: is_at_rest(emulator))
        base.recover()
        assert base.read().faults == ()
        assert exists(base.link.guardian.pid)


EVENTS = {
    "no commands": (lambda emulator, base: None, TOLD),
    "stop": (lambda emulator, base: base.stop(), 0.1),
    "connection reset": (lambda emulator, base: emulator.break_off(), 2 * TOLD),
    "server shut down": (lambda emulator, base: emulator.shut_down(), 2 * TOLD),
    "localisation lost": (
        lambda emulator, base: setattr(emulator.options, "lost", True) or drive(base),
        2 * TOLD,  # it is asked for every 0.25 s
    ),
    "guardian killed": (
        lambda emulator, base: os.kill(base.link.guardian.pid, signal.SIGKILL),
        2 * TOLD,
    ),
}
"""What happens, and within which time the base is told to rest [s]."""


@pytest.mark.slow
@pytest.mark.parametrize("what", EVENTS)
def test_the_base_is_told_to_rest_in_time(what):
    with OmronEmulator() as emulator, connected(emulator) as base:
        set_off(emulator, base)
        happens, limit = EVENTS[what]
        moment = stopwatch()
        happens(emulator, base)
        assert told_to_rest(what, emulator, moment) < limit


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGSTOP, signal.SIGKILL])
def test_the_base_is_told_to_rest_in_time_when_its_driver_is_suspended_or_killed(how):
    with OmronEmulator() as emulator, driving(emulator) as (process, _):
        moment = stopwatch()
        process.send_signal(how)
        assert told_to_rest(how.name, emulator, moment) < TOLD + 0.2
