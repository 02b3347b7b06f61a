"""Cameras that are not there, go, come back or hang; programs that are killed."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from child_in_thread import child_in_thread
from emulated_camera import D435, Counting, needs_library, picture, plugged_in
from waiting import until

from hw import FaultKind, HardwareError, WallClock
from hw.emulators.realsense import Options, RealSenseEmulator, still
from hw.realsense import RealSenseCamera, RealSenseSettings, camera_process
from hw.realsense.settings import Status

pytestmark = pytest.mark.realtime

ROOT = Path(__file__).parents[3]


def refusal(**settings) -> str:
    camera = RealSenseCamera(D435, WallClock(), RealSenseSettings(**settings))
    with pytest.raises(HardwareError) as caught:
        camera.connect()
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_without_the_library_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr("hw.realsense.settings.find_spec", lambda name: None)
    assert 'pip install "frankie-task[hardware]"' in refusal()


@needs_library
def test_without_a_camera_it_says_so_at_once():
    assert "no camera is plugged in" in refusal()


@needs_library
def test_a_wrong_address_is_named():
    why = "no emulated camera answers at 127.0.0.1:1: Connection refused"
    assert why in refusal(emulator="127.0.0.1:1")


@needs_library
def test_what_the_camera_cannot_do_is_said():
    with RealSenseEmulator(still(picture())) as emulator:
        assert "has no infrared images" in refusal(emulator=emulator.address, infrared=True)
        text = refusal(emulator=emulator.address, rate=90)
        assert "it has no depth of 640 x 480 at 90 Hz here" in text


@needs_library
@pytest.mark.slow
def test_a_camera_that_sends_nothing_is_no_camera():
    with RealSenseEmulator(still(picture()), Options(frozen=True)) as emulator:
        assert "it is plugged in and sends no images" in refusal(emulator=emulator.address)


@needs_library
@pytest.mark.parametrize("how", ["unplugged", pytest.param("frozen", marks=pytest.mark.slow)])
def test_a_camera_that_is_lost_is_a_fault_with_its_cause_and_comes_back_by_itself(how):
    with plugged_in(Counting()) as (emulator, camera, _):
        last = camera.latest()
        if how == "unplugged":
            emulator.unplug()
        else:
            emulator.options.frozen = True
        noticed = until(camera.faults)
        (fault,) = camera.faults()
        assert fault.kind is FaultKind.CONNECTION
        assert fault.clearable
        assert ("unplugged" if how == "unplugged" else "sends no images") in fault.text
        time.sleep(0.5)
        assert camera.faults() != ()
        emulator.plug_in()
        emulator.options.frozen = False
        back = until(lambda: not camera.faults())
        until(lambda: camera.latest() is not last)
        assert camera.latest().stamp > last.stamp
        print(f"{how}: noticed after {noticed:.2f} s, back after {back:.2f} s")


@needs_library
def test_a_process_that_dies_is_a_fault_and_a_recovery_starts_another():
    with plugged_in(Counting()) as (_, camera, _):
        os.kill(camera._process.process.pid, signal.SIGKILL)
        until(camera.faults)
        assert "its driver has ended" in camera.faults()[0].text
        last = camera.latest()
        camera.recover()
        assert camera.faults() == ()
        until(lambda: camera.latest() is not last)


@needs_library
def test_a_process_that_hangs_is_ended_by_a_recovery_and_replaced_by_the_next(monkeypatch):
    monkeypatch.setattr("hw.realsense.camera._RECOVERING", 0.3)
    with plugged_in(Counting()) as (_, camera, _):
        os.kill(camera._process.process.pid, signal.SIGSTOP)
        until(camera.faults)
        assert "it sends no images any more" in camera.faults()[0].text
        first = camera.faults()
        time.sleep(0.2)
        assert camera.faults() == first, "one fault, as long as it lasts"
        with pytest.raises(HardwareError, match="look at its cable"):
            camera.recover()
        camera.recover()
        assert camera.faults() == ()


@needs_library
def test_the_process_tells_why_no_images_come_and_resets_a_camera_that_hangs(monkeypatch):
    monkeypatch.setattr("hw.realsense.stream._FIRST", 0.3)
    monkeypatch.setattr("hw.realsense.stream._PATIENCE", 0.2)
    grey = np.arange(480 * 640, dtype=np.uint32).reshape(480, 640).astype(np.uint8)
    with RealSenseEmulator(still(picture(), grey), Options(infrared=True)) as emulator:
        settings = RealSenseSettings(emulator=emulator.address, infrared=True)
        camera = RealSenseCamera(D435, WallClock(), settings)
        *_, address, values = camera._process._command
        arguments = camera_process, address, json.loads(values), camera._process._memory

        def why() -> str:
            return Status.get(camera._status).trouble

        with child_in_thread(monkeypatch, *arguments) as (_, told):
            until(lambda: {"ready": True} in told())
            assert camera.report().status.serial == emulator.options.serial
            np.testing.assert_allclose(camera.latest().depth, picture(), atol=1e-6)
            np.testing.assert_array_equal(camera.latest_grey().grey, grey)
            emulator.unplug()
            until(lambda: "the emulated camera was unplugged" in why())
            emulator.plug_in()
            until(lambda: not why())
            emulator.options.frozen = True
            until(lambda: "it is plugged in and sends no images" in why())
            until(lambda: emulator.resets)
            emulator.options.frozen = False
            until(lambda: not why())
            assert told() == [{"loaded": True}, {"ready": True}]


@needs_library
@pytest.mark.parametrize("how", ["killed", pytest.param("suspended", marks=pytest.mark.slow)])
def test_the_process_of_the_driver_ends_with_the_program(how):
    program = """
import sys, time
from hw import WallClock
from hw.realsense import RealSenseCamera, RealSenseSettings
from robots import load_robot
camera = RealSenseCamera(
    load_robot("frankie").camera, WallClock(), RealSenseSettings(emulator=sys.argv[1])
)
camera.connect()
print(camera._process.process.pid, flush=True)
time.sleep(60)
"""
    with RealSenseEmulator(still(picture())) as emulator:
        parent = subprocess.Popen(
            [sys.executable, "-c", program, emulator.address],
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *filter(None, sys.path)])},
        )
        try:
            child = int(parent.stdout.readline())
            parent.send_signal(signal.SIGKILL if how == "killed" else signal.SIGSTOP)
            ended = until(lambda: not _runs(child))
            print(f"{how}: ended after {ended:.2f} s")
        finally:
            parent.kill()
            parent.wait()
            parent.stdout.close()


def _runs(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
