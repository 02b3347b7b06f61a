"""The contract of all robots, kept by the drivers of the real one on emulators of all its parts."""

import pytest
import test_robot_contract as contract
from emulated_robot import emulated, needs_drivers, robot_file

from hw import WorldOptions, open_backend

pytestmark = [needs_drivers, pytest.mark.slow]
globals().update({name: one for name, one in vars(contract).items() if name.startswith("test_")})


@pytest.fixture(scope="module")
def real(tmp_path_factory):
    path = robot_file(tmp_path_factory.mktemp("robots"))
    with emulated(path):
        yield path


@pytest.fixture
def unconnected(real):
    """Instead of the robots of the registry."""
    return open_backend(str(real), "kinematic", WorldOptions(scene="single", seed=1))


@pytest.fixture
def driven(unconnected):
    """Its loop begins when the robot is connected: real time has gone on meanwhile."""
    with unconnected.robot:
        begun = round(unconnected.clock.now() / contract.PERIOD)
        yield contract.Driven(backend=unconnected, ticks=begun)
