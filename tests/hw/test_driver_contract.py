"""Every shipped driver keeps the contract that drivers of others are checked by."""

import threading
import time
from contextlib import contextmanager, nullcontext
from dataclasses import replace

import emulated_camera
import emulated_panda
import numpy as np
import pytest
from emulated import base_of, connected
from pinocchio import SE3
from test_omron_laser import Beside
from waiting import until

from frankie_task.testing import BrokenContractError, check_driver
from hw import HardwareError
from hw.emulators.omron import OmronEmulator
from hw.emulators.realsense import RealSenseEmulator, still
from hw.omron import OmronLaser
from hw.panda.driver import HandOptions, PandaOptions, franka_hand, panda_arm
from hw.realsense import RealSenseOptions
from hw.realsense.driver import realsense_camera
from hw.state import BaseState, GripperState

pytestmark = pytest.mark.realtime

SLOW = {"patience": 60.0}  # also on a busy machine


@pytest.fixture
def panda():
    with emulated_panda.emulated("") as emulator:
        yield emulator


@pytest.mark.slow
def test_the_base():
    with OmronEmulator() as emulator:
        check_driver(
            "base", lambda _: base_of(emulator, arcl="adept"), fault=emulator.held, rest=1.0, **SLOW
        )


@pytest.mark.slow
def test_the_laser():
    with OmronEmulator(None, Beside((0.0, 0.0, 0.0))) as emulator, connected(emulator) as base:

        def make(context):
            return OmronLaser(lambda: base.echoes, context.robot.laser, context.clock)

        check_driver("laser", make, age=0.3, **SLOW)


@pytest.mark.slow
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


class Deaf:
    """A base that never stops by itself, tells nothing of faults and stamps what it likes."""

    def __init__(self, _, context):
        self.clock, self.twist = context.clock, np.zeros(3)

    def connect(self): ...

    def read(self):
        return BaseState(stamp=self.clock.now() + 1.0, wTb=SE3.Identity(), twist=self.twist)

    def send(self, twist):
        self.twist = twist
        return twist

    def stop(self): ...

    def close(self): ...


def test_what_is_not_kept_is_told():
    with pytest.raises(BrokenContractError) as broken:
        check_driver("base", lambda one: Deaf(None, one), fault=nullcontext, patience=0.5)
    told = str(broken.value)
    for words in ("ahead of the clock", "told nan", "its own watchdog", "not told within"):
        assert words in told


class Sound(Deaf):
    """A base that keeps the contract; `broken` are calls that do something else."""

    def __init__(self, context, **broken):
        super().__init__(None, context)
        self.x, self.at, self.told, self.ways = 0.0, context.clock.now(), -np.inf, []
        vars(self).update(broken)

    def advance(self):
        now = self.clock.now()
        self.x += self.twist[0] * max(0.0, min(now, self.told + 0.1) - self.at)
        self.at = now
        if now > self.told + 0.1:
            self.twist = np.zeros(3)
        return now

    def read(self):
        stamp = self.advance()
        wTb = SE3(np.eye(3), np.array([self.x, 0.0, 0.0]))
        return BaseState(stamp=stamp, wTb=wTb, twist=self.twist)

    def send(self, twist):
        self.told = self.advance()
        self.twist = np.array(twist) if np.isfinite(twist).all() else np.zeros(3)
        self.ways.append(self.x)
        return self.twist

    def stop(self):
        self.advance()
        self.twist = np.zeros(3)


class Fingers(Sound):
    """A gripper of the same kind."""

    def read(self):
        return GripperState(stamp=self.clock.now(), width=0.08, moving=False)

    def grip(self, width, force): ...


@pytest.mark.parametrize("speed", [pytest.param(0.1, marks=pytest.mark.slow), -0.1])
def test_a_base_is_driven_forth_and_back(speed):
    made = []
    check_driver("base", lambda one: made.append(Sound(one)) or made[0], speed=speed, patience=2.0)
    (base,) = made
    assert abs(base.x) < 0.05
    assert 0.08 < max(np.sign(speed) * np.array(base.ways)) < 0.2
    assert min(np.sign(speed) * np.array(base.ways)) > -0.1


def test_a_speed_that_is_rest_is_refused():
    with pytest.raises(ValueError, match="rest"):
        check_driver("base", Sound, speed=0.0)


def hang(*_):
    threading.Event().wait()


@pytest.mark.parametrize(
    "call", ["connect", "read", "send", "stop", pytest.param("close", marks=pytest.mark.slow)]
)
def test_a_base_that_hangs_is_told_and_the_check_ends(call):
    with pytest.raises(
        BrokenContractError, match=rf"`{call}` has not returned|stop.* has not returned"
    ):
        check_driver("base", lambda one: Sound(one, **{call: hang}), patience=0.3)


def test_a_hand_that_hangs_is_told_and_keeps_no_process_alive():
    with pytest.raises(BrokenContractError, match=r"`grip` has not ended after 0.3 s"):
        check_driver("gripper", lambda one: Fingers(one, grip=hang), patience=0.3)
    assert all(one.daemon for one in threading.enumerate() if one.name == "check")


@pytest.mark.parametrize(
    "call", ["connect", "read", "send", "stop", pytest.param("close", marks=pytest.mark.slow)]
)
def test_the_words_of_a_base_that_raises_are_told(call):
    def fails(*_):
        raise HardwareError("the motors are not enabled")

    with pytest.raises(
        BrokenContractError, match=f"`{call}` raises .*: the motors are not"
    ) as told:
        check_driver("base", lambda one: Sound(one, **{call: fails}), patience=0.3)
    assert str(told.value).count("\n") < 8


def test_the_words_of_a_hand_that_raises_are_told():
    def fails(*_):
        raise HardwareError("the hand is not homed")

    with pytest.raises(BrokenContractError) as told:
        check_driver("gripper", lambda one: Fingers(one, grip=fails), patience=0.3)
    assert "the hand is not homed" in str(told.value)
    assert "moving" not in str(told.value).replace("`moving` says so meanwhile", "")
