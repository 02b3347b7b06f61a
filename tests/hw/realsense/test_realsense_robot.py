"""A robot that sees with a RealSense tells when the camera is lost, and gets it back."""

import numpy as np
import pytest
from emulated_camera import needs_library, until
from test_robot_contract import PERIOD, Driven, wait_for_frame

from hw import FaultKind

pytestmark = needs_library


@pytest.fixture
def driven(emulator_and_robot):
    """Its loop begins when the robot is connected: real time has gone on meanwhile."""
    unconnected = emulator_and_robot[1]
    with unconnected.robot:
        begun = round(unconnected.clock.now() / PERIOD)
        yield Driven(backend=unconnected, ticks=begun)


def test_a_lost_camera_is_a_fault_of_the_robot_that_a_recovery_clears(emulator_and_robot, driven):
    emulator, robot = emulator_and_robot[0], driven.robot
    assert robot.read().faults == ()
    emulator.unplug()
    until(lambda: robot.read().faults)
    (fault,) = robot.read().faults
    assert (fault.kind, fault.clearable) == (FaultKind.CONNECTION, True)
    assert "unplugged" in fault.text
    robot.recover()
    assert robot.read().recovering
    emulator.plug_in()
    until(lambda: not robot.read().recovering)
    assert robot.read().faults == ()
    before = robot.camera.latest(np.inf)
    assert wait_for_frame(driven, after=before).stamp > before.stamp
