"""Robots and worlds are chosen by name, independently."""

import pytest

from config import UserError
from hw import WorldError, WorldOptions, open_backend

SINGLE = WorldOptions(scene="single")


def test_unknown_names_are_refused_with_a_suggestion():
    with pytest.raises(WorldError, match=r"`kinmatic`; did you mean `kinematic`\?"):
        open_backend("frankie", "kinmatic", SINGLE)
    for robot in ("frnkie", "no/such/robot.yaml"):
        with pytest.raises(UserError, match="frankie"):
            open_backend(robot, "kinematic", SINGLE)


def test_every_robot_is_opened_in_a_world():
    for robot in ("frankie", "omni"):
        backend = open_backend(robot, "kinematic", SINGLE)
        assert backend.robot.description.name == robot
        assert backend.truth is not None
