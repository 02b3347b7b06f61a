"""Robots and worlds by name: two things, one table each."""

import pytest

from config import UserError
from hw import WorldError, WorldOptions, open_backend, world_names

SINGLE = WorldOptions(scene="single")


def test_the_kinematic_world_is_there():
    assert "kinematic" in world_names()


def test_an_unknown_world_is_refused_with_a_suggestion():
    with pytest.raises(WorldError, match=r"`kinmatic`; did you mean `kinematic`\?"):
        open_backend("frankie", "kinmatic", SINGLE)


@pytest.mark.parametrize("robot", ["frnkie", "no/such/robot.yaml"])
def test_an_unknown_robot_is_refused(robot):
    with pytest.raises(UserError, match="frankie"):
        open_backend(robot, "kinematic", SINGLE)


def test_a_body_and_a_world_are_chosen_apart():
    for robot in ("frankie", "omni"):
        backend = open_backend(robot, "kinematic", SINGLE)
        assert backend.robot.description.name == robot
        assert backend.truth is not None
