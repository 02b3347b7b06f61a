"""The controller alone: one QP over base and arm, for a robot and a loop of your own.

No tree, no hardware, no viewer. docs/control_library.md shows its use; `terms` has the standard
terms by name.
"""

from controller import (
    OPEN_FLOOR,
    PAPER,
    PAPER_TERMS,
    STANDARD_TERMS,
    Aim,
    BaseGoal,
    Command,
    Constraints,
    ControllerSettings,
    Cost,
    GoalError,
    HolisticController,
    KinematicState,
    Limit,
    MotionGoal,
    Obstacle,
    PointCloud,
    PoseGoal,
    PostureGoal,
    RobotModel,
    Situation,
    StepReport,
    Surroundings,
    Term,
    after,
    robot_model,
)
from controller import cost_terms as terms
from robots import Box, Capsule, Cylinder, Geom, Hull, Sphere

__all__ = [
    "OPEN_FLOOR", "PAPER", "PAPER_TERMS", "STANDARD_TERMS", "Aim", "BaseGoal", "Box",
    "Capsule", "Command", "Constraints", "ControllerSettings", "Cost", "Cylinder", "Geom",
    "GoalError", "HolisticController", "Hull", "KinematicState", "Limit", "MotionGoal",
    "Obstacle", "PointCloud", "PoseGoal", "PostureGoal", "RobotModel", "Situation", "Sphere",
    "StepReport", "Surroundings", "Term", "after", "robot_model", "terms",
]  # fmt: skip
