"""The holistic reactive controller: one small QP over base and arm in every period.

After Haviland, Sünderhauf and Corke, "A Holistic Approach to Reactive Mobile Manipulation", RA-L
2022, with guidance out of local minima. Pure mathematics: no clock, no randomness but with a
fixed seed, and no input or output but posture banks.
"""

from typing import TYPE_CHECKING

from config import lazy_face

if TYPE_CHECKING:
    from controller.collision.self_collision import SelfCollision
    from controller.command import (
        Array,
        BaseGoal,
        Command,
        KinematicState,
        MotionGoal,
        PoseGoal,
        PostureGoal,
    )
    from controller.controller import HolisticController
    from controller.floor.base_drive import Pose2D
    from controller.model import RobotModel, manipulability, robot_model
    from controller.planning.arm_planner import PlanningSettings
    from controller.planning.planning_controller import PlanningController
    from controller.planning.rrt import PlanningError, planning_library
    from controller.report import MotionController, StepReport
    from controller.settings import PAPER, PRESETS, ControllerSettings
    from controller.stance.finder import stance_search, why_no_stance
    from controller.stance.free_space import se3_of
    from controller.stance.posture_bank import bank
    from controller.stance.reach import farthest, out_of_reach, reached_instead
    from controller.stance.ready import ready_posture
    from controller.surroundings import OPEN_FLOOR, Obstacle, PointCloud, Surroundings
    from controller.validation import GoalError
else:
    __getattr__ = lazy_face(__name__)
