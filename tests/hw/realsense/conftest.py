"""What the tests of a robot with a RealSense share."""

import pytest

from hw import Backend, ComposedRobot, WallClock, one_thread
from hw.emulators.realsense import RealSenseEmulator, of_camera
from hw.realsense import RealSenseCamera, RealSenseSettings
from hw.sim import D435Noise, Dynamics, load_scene
from hw.sim.kinematic import KinematicBody
from hw.sim.robot import SimArm, SimBase, SimCamera, SimGripper
from robots import load_robot


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
