"""Cameras that are not there, go, come back or hang; programs that are killed."""

import json
import os
import signal
import time

import numpy as np
import pytest
from child_in_thread import child_in_thread
from emulated_camera import D435, Counting, needs_library, picture, plugged_in
from program import exists, program
from waiting import until

from drivers.realsense import RealSenseCamera, RealSenseSettings, camera_process
from drivers.realsense.device_settings import Status
from extensions.emulators.realsense import Options, RealSenseEmulator, still
from hw import FaultKind, HardwareError, WallClock


def refusal(**settings) -> str:
    camera = RealSenseCamera(D435, WallClock(), RealSenseSettings(**settings))
    with pytest.raises(HardwareError) as caught:
        camera.connect()
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_without_the_library_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr("drivers.realsense.device_settings.find_spec", lambda name: None)
    assert 'pip install "frankie-task[hardware]"' in refusal()


@needs_library
def test_a_camera_that_is_not_there_or_cannot_is_named():
    assert "no camera is plugged in" in refusal()
    why = "no emulated camera answers at 127.0.0.1:1: Connection refused"
    assert why in refusal(emulator="127.0.0.1:1")
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
@pytest.mark.realtime
def test_a_camera_that_is_unplugged_is_a_fault_with_its_cause_and_comes_back_by_itself():
    with plugged_in(Counting()) as (emulator, camera, _):
        last = camera.latest()
        emulator.unplug()
        until(camera.faults)
        (fault,) = camera.faults()
        assert fault.kind is FaultKind.CONNECTION
        assert fault.clearable
        assert "unplugged" in fault.text
        time.sleep(0.5)
        assert camera.faults() != ()
        emulator.plug_in()
        until(lambda: not camera.faults())
        until(lambda: camera.latest() is not last)
        assert camera.latest().stamp > last.stamp


@needs_library
@pytest.mark.realtime
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
@pytest.mark.realtime
def test_a_process_that_hangs_is_ended_by_a_recovery_and_replaced_by_the_next(monkeypatch):
    monkeypatch.setattr("drivers.realsense.camera._RECOVERING", 0.3)
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
@pytest.mark.realtime
def test_the_process_tells_why_no_images_come_and_resets_a_camera_that_hangs(monkeypatch):
    monkeypatch.setattr("drivers.realsense.stream._FIRST", 0.3)
    monkeypatch.setattr("drivers.realsense.stream._PATIENCE", 0.2)
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


PARENT = """
import sys, time
from hw import WallClock
from drivers.realsense import RealSenseCamera, RealSenseSettings
from robots import load_robot
settings = RealSenseSettings(emulator=sys.argv[1])
camera = RealSenseCamera(load_robot("frankie").camera, WallClock(), settings)
camera.connect()
print(camera._process.process.pid, flush=True)
time.sleep(60)
"""


@needs_library
@pytest.mark.realtime
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_the_process_of_the_driver_ends_with_the_program(how):
    with (
        RealSenseEmulator(still(picture())) as emulator,
        program(PARENT, emulator.address) as parent,
    ):
        child = int(parent.stdout.readline())
        parent.send_signal(how)
        until(lambda: not exists(child))
