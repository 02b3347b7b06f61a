"""The driver's process is suspended or killed while the base moves."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from emulated import (
    SPEED,
    connected,
    is_at_rest,
    measured,
    rest_after,
    set_off,
    wait_for,
    wait_for_fault,
)

from hw import FaultKind
from hw.clock import stopwatch
from hw.emulators.omron import OmronEmulator, Options
from hw.emulators.omron.controller import Teleop

SCRIPT = Path(__file__).with_name("driving_process.py")
TOLD = 0.25
"""The base is told to rest within this time [s]."""
BUSY = 0.2
"""A busy machine may need this in addition, to run the process that tells it [s]."""


@contextmanager
def driving(emulator: OmronEmulator) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """A process that drives the emulated base, and the process that guards it."""
    process = subprocess.Popen(
        [sys.executable, str(SCRIPT), str(emulator.port)], stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        guardian = int(process.stdout.readline())
        wait_for(lambda: is_moving(emulator))
        yield process, guardian
    finally:
        process.kill()
        process.wait()
        if process.stdout is not None:
            process.stdout.close()


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
        suspended = stopwatch()
        process.send_signal(signal.SIGSTOP)
        assert measured("suspended", emulator, suspended) < TOLD + BUSY
        assert emulator.heard[-1].name == "stop"
        before = len(emulator.heard)

        process.send_signal(signal.SIGCONT)
        wait_for(lambda: is_moving(emulator))  # its commands are fresh again
        ratios = [one.values for one in list(emulator.heard)[before:] if not one.is_zero]
        assert ratios[0][0] * ratios[0][2] <= 100.0 * 10.5  # it begins slowly: by a pulse

        killed = stopwatch()
        process.kill()
        assert measured("killed", emulator, killed) < TOLD + BUSY
        wait_for(lambda: not exists(guardian))
        wait_for(lambda: not emulator._clients)


def test_without_its_guardian_the_driver_does_not_go_on():
    with OmronEmulator() as emulator, connected(emulator) as base:
        last = set_off(emulator, base)
        os.kill(base.guardian_pid, signal.SIGKILL)
        wait_for_fault(base, FaultKind.CONNECTION, "guards it")
        assert measured("guardian killed", emulator, last) < 2 * TOLD
        base.recover()
        assert base.read().faults == ()
        assert exists(base.guardian_pid)


def test_killed_with_its_guardian_the_base_stops_by_its_own_timeout():
    """What holds without anything of ours; on the robot 2 s unless somebody has changed it."""
    options = Options(teleop=Teleop(timeout=0.5))
    with OmronEmulator(options) as emulator, driving(emulator) as (process, guardian):
        process.send_signal(signal.SIGSTOP)
        os.kill(guardian, signal.SIGKILL)
        killed = stopwatch()
        process.kill()
        stands = rest_after(emulator, killed)
        print(f"killed with its guardian, timeout of the base 0.5 s: stands after {stands:.2f} s")
        assert stands < 0.5 + 0.1 + SPEED / 0.6 + BUSY
        assert emulator.heard[-1].name == "ratioDrive"
        assert not emulator.heard[-1].is_zero
        assert is_at_rest(emulator)
