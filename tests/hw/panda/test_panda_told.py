"""What the drivers measure against what they told, and what they never leave at work."""

from __future__ import annotations

import os
import re
import subprocess
import sys

import numpy as np
import pytest
from emulated_panda import connected, drive, emulated, moves, needs_library, until

from hw import HardwareError, WallClock
from hw.panda import PandaArm


@needs_library
def test_a_joint_that_is_faster_than_it_was_told_is_stopped():
    with emulated("") as emulator, connected(PandaArm(emulator.address, WallClock())) as arm:
        emulator.do("rush 0.2")  # less than the margin
        assert moves(arm)
        emulator.do("rush 0.5")
        faults = drive(arm, 1.0)
        assert faults == list(arm.read().faults)
        (fault,) = faults
        assert re.search(r"joint 1 moved at 0.\d+ rad/s and was told 0.00 rad/s", fault.text)
        told = emulator.wait(lambda told: told["resting"] > 0.0)
        assert told["mode"] == "IDLE"
        emulator.do("rush")
        arm.recover()
        assert moves(arm)


@needs_library
def test_a_way_that_takes_too_long_is_ended(monkeypatch):
    monkeypatch.setattr("hw.panda.arm._WAY", 0.5)
    with emulated("") as emulator, connected(PandaArm(emulator.address, WallClock())) as arm:
        with pytest.raises(HardwareError, match="no answer"):
            arm.move_to(arm.read().q + np.eye(7)[6], speed=0.2)
        emulator.wait(lambda told: told["resting"] > 0.0, 2.0)


@needs_library
def test_a_driver_that_gets_no_time_is_no_cable():
    with emulated("") as emulator, connected(PandaArm(emulator.address, WallClock())) as arm:
        process = arm._process.process
        process.send_signal(19)  # SIGSTOP
        until(lambda: arm.read().faults)
        texts = {fault.text for _ in range(20) for fault in drive(arm, 0.05)}
        process.send_signal(18)  # SIGCONT
        (text,) = texts
        assert "this computer is too busy" in text


def test_waiting_for_a_processor_is_measured():
    code = "while True: pass"
    processor = min(os.sched_getaffinity(0))
    others = [subprocess.Popen([sys.executable, "-c", code]) for _ in range(2)]
    measure = (
        "import time; from hw.panda.arm_process import _waited; before, until = _waited(), "
        "time.monotonic() + 1.0\nwhile time.monotonic() < until: pass\nprint(_waited() - before)"
    )
    try:
        for other in others:
            os.sched_setaffinity(other.pid, {processor})
        command = ["taskset", "-c", str(processor), sys.executable, "-c", measure]
        told = subprocess.run(command, check=True, capture_output=True, text=True)
    finally:
        for other in others:
            other.kill()
            other.wait()
    assert float(told.stdout) > 0.2


@needs_library
def test_the_process_of_the_arm_stays_in_memory():
    with emulated("") as emulator, connected(PandaArm(emulator.address, WallClock())) as arm:
        with open(f"/proc/{arm._process.process.pid}/status") as status:
            locked = re.search(r"VmLck:\s+(\d+)", status.read())
        assert int(locked[1]) > 0
        reading = arm.reading()
        assert (reading.hand_mass, reading.load) == (pytest.approx(0.73), 0.0)
