"""Goals and settings that make no sense are refused by name."""

from dataclasses import replace

import numpy as np
import pytest
from motion import READY, State, tool_pose
from pinocchio import SE3

from controller import (
    BaseGoal,
    Command,
    ControllerSettings,
    GoalError,
    HolisticController,
    PoseGoal,
    PostureGoal,
    robot_model,
)
from controller.settings import JointLimitSettings

POSE = PoseGoal(wTe=tool_pose(1.0, 0.0, 0.7))
BASE = BaseGoal(wTb=SE3.Identity())


def step(goal) -> None:
    HolisticController(robot_model("frankie")).step(State(), goal, Command.stop(7))


@pytest.mark.parametrize(
    ("goal", "field", "value"),
    [
        (POSE, "speed", 0.0),
        (POSE, "turn_rate", np.nan),
        (POSE, "position_tolerance", -0.01),
        (PostureGoal(q=READY), "tolerance", np.nan),
        (BASE, "speed", -1.0),
        (BASE, "heading_tolerance", -0.01),
    ],
)
def test_a_goal_with_a_number_that_makes_no_sense_is_refused_by_name(goal, field, value):
    name = field.replace("_", " ")
    with pytest.raises(GoalError, match=f"the goal's {name} must be a number"):
        step(replace(goal, **{field: value}))


def test_a_posture_has_as_many_joints_as_the_arm():
    with pytest.raises(GoalError, match="the goal posture must have 7 joints"):
        step(PostureGoal(q=np.zeros(6)))


def test_settings_are_positive_numbers():
    with pytest.raises(ValueError, match="`period` of ControllerSettings must be a number above 0"):
        ControllerSettings(period=np.nan)
    with pytest.raises(ValueError, match="`smoothness` of ControllerSettings must be at least 0"):
        ControllerSettings(smoothness=-1.0)
    with pytest.raises(ValueError, match="`influence_distance` must be larger"):
        JointLimitSettings(influence_distance=0.03, stop_distance=0.03)
