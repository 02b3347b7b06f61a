"""Every shipped driver keeps the contract that drivers of others are checked by."""

import time
from contextlib import contextmanager
from dataclasses import replace

import emulated_camera
import emulated_panda
import pytest
from emulated import base_of, connected
from test_omron_laser import Beside
from waiting import until

from config.planar import Pose2D
from drivers.omron import OmronLaser
from drivers.panda.driver import HandOptions, PandaOptions, franka_hand, panda_arm
from drivers.realsense import RealSenseOptions
from drivers.realsense.driver import realsense_camera
from extensions.emulators.omron import OmronEmulator
from extensions.emulators.realsense import RealSenseEmulator, still
from frankie_task.testing import check_driver

SLOW = {"patience": 60.0}  # also on a busy machine


@pytest.fixture
def panda():
    with emulated_panda.emulated() as emulator:
        yield emulator


@pytest.mark.slow
@pytest.mark.realtime
def test_the_base():
    with OmronEmulator() as emulator:
        check_driver(
            "base", lambda _: base_of(emulator, arcl="adept"), fault=emulator.held, rest=1.0, **SLOW
        )


@pytest.mark.slow
@pytest.mark.realtime
def test_the_laser():
    with (
        OmronEmulator(None, Beside(Pose2D(0.0, 0.0, 0.0))) as emulator,
        connected(emulator) as base,
    ):

        def make(context):
            return OmronLaser(lambda: base.echoes, context.robot.laser, context.clock)

        check_driver("laser", make, age=0.3, **SLOW)


@pytest.mark.slow
@pytest.mark.realtime
@emulated_panda.needs_library
def test_the_arm(panda):
    @contextmanager
    def stopped():
        panda.do("stop")
        yield
        panda.do("release")

    options = PandaOptions(address=panda.address)
    check_driver("arm", lambda context: panda_arm(options, context), fault=stopped, **SLOW)


@pytest.mark.slow
@pytest.mark.realtime
@emulated_panda.needs_library
def test_the_hand(panda):
    @contextmanager
    def unplugged():
        begun = time.monotonic()
        panda.do("unplug 3")
        yield
        until(lambda: time.monotonic() > begun + 3.0)

    options = HandOptions(address=panda.address)
    check_driver("gripper", lambda context: franka_hand(options, context), fault=unplugged, **SLOW)


@pytest.mark.slow
@pytest.mark.realtime
@emulated_camera.needs_library
def test_the_camera():
    with RealSenseEmulator(still(emulated_camera.picture())) as emulator:

        @contextmanager
        def unplugged():
            emulator.unplug()
            yield
            emulator.plug_in()

        def make(context):
            return realsense_camera(RealSenseOptions(), replace(context, emulator=emulator.address))

        check_driver("camera", make, fault=unplugged, age=0.2, **SLOW)
