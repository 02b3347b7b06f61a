"""What is true of the shipped robots, against published numbers and against itself."""

import numpy as np
import pytest

from controller import RobotModel, SelfCollision
from robots import RobotDescription, load_robot, robot_names, with_base_speeds


@pytest.fixture(params=robot_names())
def robot(request: pytest.FixtureRequest) -> RobotDescription:
    return load_robot(request.param)


def test_the_ready_posture_is_allowed_and_clear(robot: RobotDescription) -> None:
    limits, q = robot.limits, robot.arm.ready
    assert (limits.q_min < q).all()
    assert (q < limits.q_max).all()
    assert SelfCollision(RobotModel(robot)).clearance(q) > 0.1


def test_reverse_limits_only_the_way_back(robot: RobotDescription) -> None:
    model = RobotModel(with_base_speeds(robot, 0.8))
    lower, upper = model.velocity_limits
    forward = int(np.argmax(robot.base.axes[0]))
    others = np.arange(len(upper)) != forward
    np.testing.assert_array_equal(lower[others], -upper[others])
    assert upper[forward] == 0.8
    share = robot.limits.base_reverse / robot.limits.base_twist[0]
    assert lower[forward] == pytest.approx(-0.8 * share)


def test_every_pair_that_may_touch_is_measured(robot: RobotDescription) -> None:
    """Postures that fold the hand onto its own base are found by the pairs of the file."""
    body = SelfCollision(RobotModel(robot))
    folded = np.array([0.0, -1.7, 0.0, -3.0, 0.0, 0.5, 0.8])
    assert body.clearance(folded) < 0.0
