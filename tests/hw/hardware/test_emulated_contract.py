"""The contract of all robots, kept by the drivers of the real one on emulators of all its parts.

What is not slow is its short form.
"""

import functools

import pytest
import test_robot_contract as contract
from emulated_robot import emulated, needs_drivers, robot_file

from hw import WorldOptions, open_backend

pytestmark = needs_drivers
SHORT = (
    "test_a_reading_is_finite_and_of_the_right_shape",
    "test_stamps_are_those_of_the_session_clock_and_never_go_back",
    "test_the_base_follows_a_twist",
    "test_a_joint_follows_its_velocity_and_the_others_stay",
    "test_a_grip_is_started_at_once_and_tells_when_it_has_ended",
    "test_a_frame_knows_where_it_was_captured",
)


def slow(check):
    """The same test, marked; the one of the contract itself stays as it is."""

    @functools.wraps(check)
    def marked(*arguments, **named):
        return check(*arguments, **named)

    return pytest.mark.slow(marked)


for name, check in list(vars(contract).items()):
    if name.startswith("test_"):
        globals()[name] = check if name in SHORT else slow(check)


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
