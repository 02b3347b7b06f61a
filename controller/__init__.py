"""The holistic reactive controller: one small QP a tick over base and arm.

After Haviland, Sünderhauf and Corke, "A Holistic Approach to Reactive Mobile Manipulation", RA-L
2022. Pure mathematics: no clock, no input or output, no randomness.
"""

from controller.command import (
    N_ARM,
    BaseGoal,
    Command,
    KinematicState,
    MotionGoal,
    PoseGoal,
    PostureGoal,
)
from controller.controller import GoalError, HolisticController, StepReport
from controller.model import (
    FRANKIE,
    HAND_TO_TOOL,
    OMNI,
    READY,
    ROBOTS,
    Limits,
    RobotModel,
    manipulability,
    robot_model,
)
from controller.settings import ControllerSettings

__all__ = [
    "FRANKIE",
    "HAND_TO_TOOL",
    "N_ARM",
    "OMNI",
    "READY",
    "ROBOTS",
    "BaseGoal",
    "Command",
    "ControllerSettings",
    "GoalError",
    "HolisticController",
    "KinematicState",
    "Limits",
    "MotionGoal",
    "PoseGoal",
    "PostureGoal",
    "RobotModel",
    "StepReport",
    "manipulability",
    "robot_model",
]
