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
from controller.settings import JointLimitSettings, ServoSettings

POSE = PoseGoal(wTe=tool_pose(1.0, 0.0, 0.7))
POSTURE = PostureGoal(q=READY)
BASE = BaseGoal(wTb=SE3.Identity())

BAD = [
    (POSE, "speed", "speed", [0.0, -1.0, np.nan, np.inf]),
    (POSE, "turn_rate", "turn rate", [0.0, -1.0, np.nan, np.inf]),
    (POSE, "position_tolerance", "position tolerance", [-0.01, np.nan]),
    (POSE, "orientation_tolerance", "orientation tolerance", [-0.01, np.nan]),
    (POSTURE, "tolerance", "tolerance", [-0.01, np.nan]),
    (BASE, "position_tolerance", "position tolerance", [-0.01, np.nan]),
    (BASE, "heading_tolerance", "heading tolerance", [-0.01, np.nan]),
]


@pytest.mark.parametrize(
    ("goal", "field", "name", "value"),
    [(goal, field, name, value) for goal, field, name, values in BAD for value in values],
)
def test_a_goal_with_a_number_that_makes_no_sense_is_refused_by_name(goal, field, name, value):
    controller = HolisticController(robot_model("frankie"))
    controller.step(State(), goal, Command.stop())
    with pytest.raises(GoalError, match=f"the goal's {name} must be a number"):
        controller.step(State(), replace(goal, **{field: value}), Command.stop())


@pytest.mark.parametrize("joints", [0, 6, 8])
def test_a_posture_has_as_many_joints_as_the_arm(joints):
    controller = HolisticController(robot_model("frankie"))
    with pytest.raises(GoalError, match="the goal posture must have 7 joints"):
        controller.step(State(), PostureGoal(q=np.zeros(joints)), Command.stop())


@pytest.mark.parametrize("period", [0.0, -0.01, np.nan])
def test_a_period_that_is_none_is_refused(period):
    with pytest.raises(ValueError, match="`period` of ControllerSettings must be a number above 0"):
        ControllerSettings(period=period)


@pytest.mark.parametrize("value", [-1.0, np.nan])
def test_settings_are_never_negative_and_always_numbers(value):
    with pytest.raises(ValueError, match="`smoothness` of ControllerSettings must be at least 0"):
        ControllerSettings(smoothness=value)
    with pytest.raises(ValueError, match="`gain` of ServoSettings must be a number above 0"):
        ServoSettings(gain=value)


def test_a_damper_begins_before_it_ends():
    with pytest.raises(ValueError, match="`influence_distance` must be larger"):
        JointLimitSettings(influence_distance=0.03, stop_distance=0.03)
