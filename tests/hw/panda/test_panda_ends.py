"""How the driver begins and ends: what it says when it cannot, and who stops the arm then."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest
from emulated_panda import ROOT, Emulator, free_address, needs_library
from waiting import until

from hw import FaultKind, HardwareError, WallClock
from hw.panda import PandaArm

pytestmark = pytest.mark.realtime

PARENT = """
import sys, time
import numpy as np
from hw import WallClock
from hw.panda import PandaArm
arm = PandaArm(sys.argv[1], WallClock())
arm.connect()
while True:
    arm.send(np.array([0.3, 0, 0, 0, 0, 0, 0.0]))
    print(time.monotonic(), flush=True)
    time.sleep(0.01)
"""


def refusal(address: str) -> str:
    arm = PandaArm(address, WallClock(), connecting=1.5)
    with pytest.raises(HardwareError) as caught:
        arm.connect()
    text = str(caught.value)
    assert address in text
    assert "\n" not in text
    return text


def test_without_the_library_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr("hw.panda.library.find_spec", lambda _: None)
    arm = PandaArm("127.0.0.1", WallClock())
    with pytest.raises(HardwareError, match=r'pip install "frankie-task\[hardware\]"'):
        arm.connect()


@needs_library
def test_where_nobody_listens_fci_is_not_active():
    assert "activate FCI" in refusal(free_address())
    assert "no such host" in refusal("no-such-panda.invalid")


@needs_library
@pytest.mark.parametrize(
    "how", [signal.SIGKILL, pytest.param(signal.SIGSTOP, marks=pytest.mark.slow)]
)
def test_the_arm_stops_and_the_driver_ends_when_its_parent_is_killed_or_suspended(emulator, how):
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT, emulator.address],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])},
    )
    try:
        emulator.wait(lambda told: told["mode"] == "MOVE" and told["qd"][0] > 0.28)
        os.kill(parent.pid, how)
        told = emulator.wait(lambda told: told["still"] > 0.0)
        assert told["errors"] == told["violations"] == []
        told = emulator.wait(lambda told: not told["has_commander"])
        assert told["mode"] == "IDLE"
    finally:
        parent.kill()
        parent.wait()


@needs_library
def test_a_driver_that_is_killed_is_a_fault_and_a_recovery_starts_another(emulator):
    arm = PandaArm(emulator.address, WallClock())
    arm.connect()
    try:
        process = arm._process.process
        assert process is not None
        process.kill()
        until(lambda: arm.read().faults)
        (fault,) = arm.read().faults
        assert fault.kind is FaultKind.CONNECTION
        arm.recover()
        assert arm.read().faults == ()
    finally:
        arm.close()
    arm.close()


@needs_library
@pytest.mark.slow
def test_a_robot_that_is_switched_off_is_a_fault():
    emulator = Emulator()
    arm = PandaArm(emulator.address, WallClock(), connecting=1.5)
    arm.connect()
    try:
        emulator.process.kill()
        until(lambda: arm.read().faults)
        assert arm.read().faults[0].kind is FaultKind.CONNECTION
        with pytest.raises(HardwareError, match="activate FCI"):
            arm.recover()
        assert arm.read().faults[0].kind is FaultKind.CONNECTION
    finally:
        arm.close()
        emulator.process.wait()
