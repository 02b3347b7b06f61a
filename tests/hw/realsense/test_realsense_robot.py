"""A robot that sees with a RealSense keeps the contract of all robots; a lost camera is told."""

import numpy as np
import pytest
from emulated_camera import needs_library, until
from test_robot_contract import *  # noqa: F403
from test_robot_contract import PERIOD, Driven, wait_for_frame

from hw import Backend, ComposedRobot, FaultKind, WallClock, one_thread
from hw.emulators.realsense import RealSenseEmulator, of_camera
from hw.realsense import RealSenseCamera, RealSenseSettings
from hw.sim import D435Noise, Dynamics, load_scene
from hw.sim.kinematic import KinematicBody
from hw.sim.robot import SimArm, SimBase, SimCamera, SimGripper
from robots import load_robot

pytestmark = needs_library


@pytest.fixture
def emulator_and_robot():
    """A simulated robot whose images go over a socket and through the vendor's library."""
    description, clock = load_robot("frankie"), WallClock()
    world = load_scene("single", 1, description.base.size[:2])
    body = KinematicBody(description, world, clock, Dynamics())
    simulated = SimCamera(body, D435Noise(), 1, one_thread())
    with RealSenseEmulator(of_camera(simulated, clock)) as emulator:
        settings = RealSenseSettings(emulator=emulator.address)
        robot = ComposedRobot(
            description,
            arm=SimArm(body),
            base=SimBase(body),
            gripper=SimGripper(body),
            camera=RealSenseCamera(description.camera, clock, settings),
            clock=clock,
        )
        yield emulator, Backend(robot=robot, clock=clock, truth=None)


@pytest.fixture
def unconnected(emulator_and_robot):
    """Instead of the robots of the registry."""
    return emulator_and_robot[1]


@pytest.fixture
def driven(unconnected):
    """Its loop begins when the robot is connected: real time has gone on meanwhile."""
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
