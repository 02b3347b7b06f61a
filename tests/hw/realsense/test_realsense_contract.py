"""The contract of all robots, kept by one that sees with a RealSense."""

import pytest
from emulated_camera import needs_library
from test_robot_contract import *  # noqa: F403
from test_robot_contract import PERIOD, Driven

pytestmark = [needs_library, pytest.mark.slow]


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
