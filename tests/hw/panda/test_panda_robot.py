"""A robot with arm and hand of an emulated Panda, through the composition of all robots."""

from __future__ import annotations

import time

import numpy as np
import pytest
from emulated_panda import Emulator, needs_library, until
from pinocchio import SE3

from controller import Command
from hw import BaseState, ComposedRobot, DepthImage, FaultKind, WallClock
from hw.panda import PandaArm, PandaHand
from robots import load_robot

pytestmark = needs_library


class Standing:
    """A base that stands, with a camera that sees nothing."""

    def __init__(self, clock) -> None:
        self._clock = clock

    def connect(self) -> None: ...
    def stop(self) -> None: ...
    def close(self) -> None: ...
    def recover(self) -> None: ...

    def read(self) -> BaseState:
        return BaseState(stamp=self._clock.now(), wTb=SE3.Identity(), twist=np.zeros(3))

    def send(self, twist):
        return np.zeros(3)

    def latest(self) -> DepthImage | None:
        return None

    def faults(self) -> tuple[()]:
        return ()


@pytest.fixture
def emulator():
    emulator = Emulator()
    yield emulator
    emulator.close()


@pytest.fixture
def robot(emulator):
    clock = WallClock()
    with ComposedRobot(
        load_robot("frankie"),
        arm=PandaArm(emulator.address, clock),
        base=Standing(clock),
        gripper=PandaHand(emulator.address, clock),
        camera=Standing(clock),
        clock=clock,
    ) as robot:
        yield robot


def test_a_composed_robot_moves_grips_and_recovers(robot, emulator):
    command = Command(base_twist=np.zeros(3), qd=0.2 * np.eye(7)[5])

    def send(wanted, seconds) -> None:
        for _ in range(round(seconds * 100)):
            robot.read()
            robot.send(wanted)
            time.sleep(0.01)

    stamps = [robot.read().stamp]
    robot.grip(0.02, 20.0)
    assert robot.read().gripper_moving
    send(command, 0.4)
    state = robot.read()
    stamps.append(state.stamp)
    assert state.qd[5] == pytest.approx(0.2, abs=0.02)
    assert stamps == sorted(stamps)
    until(lambda: not robot.read().gripper_moving)
    time.sleep(0.1)
    assert robot.read().gripper_width == pytest.approx(0.02, abs=1e-3)

    emulator.do("reflex")
    until(lambda: robot.read().faults)
    (fault,) = robot.read().faults
    assert fault.kind is FaultKind.REFLEX
    assert not robot.send(command).qd.any()
    robot.recover()
    assert robot.read().recovering
    until(lambda: not robot.read().recovering)
    assert robot.read().faults == ()
    send(Command.stop(), 0.1)

    def moves_again() -> bool:
        send(command, 0.1)
        return bool(robot.read().qd[5] > 0.1)

    until(moves_again)
