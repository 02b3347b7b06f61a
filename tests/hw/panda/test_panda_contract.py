"""The contract of all robots, kept by one with arm and hand of an emulated Panda.

Base and camera are those of the kinematic simulator, on real time.
"""

import pytest
import test_robot_contract as contract
from emulated_panda import needs_library
from test_robot_contract import *  # noqa: F403

from hw import Backend, ComposedRobot, WallClock, one_thread
from hw.panda import PandaArm, PandaHand
from hw.sim import Dynamics, load_scene
from hw.sim.camera.noise import D435Noise
from hw.sim.kinematic import KinematicBody
from hw.sim.robot import SimBase, SimCamera
from robots import load_robot

pytestmark = [needs_library, pytest.mark.slow]


@pytest.fixture
def unconnected(emulator):
    """Instead of the robots of the registry."""
    description, clock = load_robot("frankie"), WallClock()
    world = load_scene("single", 1, description.base.size[:2])
    body = KinematicBody(description, world, clock, Dynamics())
    robot = ComposedRobot(
        description,
        arm=PandaArm(emulator.address, clock),
        base=SimBase(body),
        gripper=PandaHand(emulator.address, clock),
        camera=SimCamera(body, D435Noise(), 1, one_thread()),
        clock=clock,
    )
    return Backend(robot=robot, clock=clock, truth=None)


@pytest.fixture
def driven(unconnected):
    """Its loop begins when the robot is connected: real time has gone on meanwhile."""
    with unconnected.robot:
        begun = round(unconnected.clock.now() / contract.PERIOD)
        yield contract.Driven(backend=unconnected, ticks=begun)
