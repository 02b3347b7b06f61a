"""What a driver breaks of the contract is told, whatever it does."""

import re
import threading
import time
from contextlib import nullcontext

import numpy as np
import pytest
from pinocchio import SE3

from frankie_task.testing import BrokenContractError, check_driver
from hw import HardwareError, SimClock
from hw.state import BaseState, GripperState


class Stepped(SimClock):
    """Passes where somebody sleeps, and other threads get their turn meanwhile."""

    def sleep_until(self, stamp):
        super().sleep_until(stamp)
        time.sleep(3e-4)


@pytest.fixture
def stepped(monkeypatch):
    monkeypatch.setattr("frankie_task.contract.WallClock", Stepped)


class Deaf:
    """A base that never stops by itself, tells nothing of faults and stamps what it likes."""

    def __init__(self, context):
        self.clock, self.twist = context.clock, np.zeros(3)

    def connect(self): ...

    def read(self):
        return BaseState(stamp=self.clock.now() + 1.0, oTb=SE3.Identity(), twist=self.twist)

    def send(self, twist):
        self.twist = twist
        return twist

    def stop(self): ...

    def close(self): ...


def test_what_is_not_kept_is_told(stepped):
    with pytest.raises(BrokenContractError) as broken:
        check_driver("base", Deaf, fault=nullcontext, patience=0.5)
    told = str(broken.value)
    for words in ("ahead of the clock", "told nan", "watchdog. But it still", "not told within"):
        assert words in told


class Sound(Deaf):
    """A base that keeps the contract; `broken` are calls that do something else."""

    def __init__(self, context, **broken):
        super().__init__(context)
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
        oTb = SE3(np.eye(3), np.array([self.x, 0.0, 0.0]))
        return BaseState(stamp=stamp, oTb=oTb, twist=self.twist)

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


@pytest.mark.parametrize("speed", [0.1, -0.1])
def test_a_base_is_driven_forth_and_back(stepped, speed):
    made = []
    check_driver("base", lambda one: made.append(Sound(one)) or made[0], speed=speed, patience=2.0)
    (base,) = made
    assert abs(base.x) < 0.05
    assert 0.08 < max(np.sign(speed) * np.array(base.ways)) < 0.2
    assert min(np.sign(speed) * np.array(base.ways)) > -0.1


def test_a_speed_that_is_rest_is_refused():
    with pytest.raises(ValueError, match="rest"):
        check_driver("base", Sound, speed=0.0)


CALLS = ("connect", "read", "send", "stop", "close", "grip")


def broken_by(call, does):
    """What the check tells of a part of which one call does something else."""
    kind, make = ("gripper", Fingers) if call == "grip" else ("base", Sound)
    with pytest.raises(BrokenContractError) as broken:
        check_driver(kind, lambda one: make(one, **{call: does}), patience=0.3)
    return str(broken.value)


@pytest.mark.parametrize("call", CALLS)
def test_a_call_that_hangs_is_told_and_the_check_ends(stepped, call):
    told = broken_by(call, lambda *_: threading.Event().wait())
    assert re.search(rf"`{call}` has not (returned|ended)|stop.* has not returned", told)
    assert all(one.daemon for one in threading.enumerate() if one.name == "check")


@pytest.mark.parametrize("call", CALLS)
def test_the_words_of_a_call_that_raises_are_told(stepped, call):
    def fails(*_):
        raise HardwareError("the motors are not enabled")

    told = broken_by(call, fails)
    assert re.search(f"`{call}` raises .*: the motors are not", told)
    assert told.count("\n") < 8
    assert "moving" not in told.replace("`moving` says so meanwhile", "")
