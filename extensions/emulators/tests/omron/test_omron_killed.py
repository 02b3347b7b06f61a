"""The driver or its guardian is killed or suspended; how soon the base is told to rest."""

import os
import signal

import pytest
from emulated import SPEED, TOLD, connected, set_off, told_to_rest, wait_for_fault
from program import exists, program
from waiting import until

from extensions.emulators.omron import OmronEmulator
from hw import FaultKind
from hw.clock import stopwatch

pytestmark = pytest.mark.realtime

SCRIPT = """
import sys, time
import numpy as np
from hw import WallClock
from drivers.omron import OmronBase, OmronOptions
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


def is_moving(emulator: OmronEmulator) -> bool:
    return emulator.controller.drive.twist()[0] > 0.8 * SPEED


def test_suspended_the_base_is_stopped_and_killed_it_is_stopped_too():
    with OmronEmulator() as emulator, program(SCRIPT, emulator.port) as process:
        guardian = int(process.stdout.readline())
        until(lambda: is_moving(emulator))
        moment = stopwatch()
        process.send_signal(signal.SIGSTOP)
        assert told_to_rest("suspended", emulator, moment) < TOLD + 0.2
        until(lambda: emulator.heard[-1].name == "stop")
        before = len(emulator.heard)
        process.send_signal(signal.SIGCONT)
        until(lambda: is_moving(emulator))  # its commands are fresh again
        ratios = [one.values for one in list(emulator.heard)[before:] if not one.is_zero]
        assert ratios[0][0] <= 10.5  # it begins slowly: by a pulse
        moment = stopwatch()
        process.kill()
        assert told_to_rest("killed", emulator, moment) < TOLD + 0.2
        until(lambda: not exists(guardian) and not emulator.clients)


def test_without_its_guardian_the_driver_does_not_go_on():
    with OmronEmulator() as emulator, connected(emulator) as base:
        set_off(emulator, base)
        moment = stopwatch()
        os.kill(base.link.guardian.pid, signal.SIGKILL)
        assert told_to_rest("guardian killed", emulator, moment) < 2 * TOLD
        wait_for_fault(base, FaultKind.CONNECTION, "guards it")
        base.recover()
        assert base.read().faults == ()
        assert exists(base.link.guardian.pid)
