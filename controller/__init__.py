"""The holistic reactive controller: one small QP over base and arm in every period.

After Haviland, Sünderhauf and Corke, "A Holistic Approach to Reactive Mobile Manipulation", RA-L
2022, with guidance out of local minima. Pure mathematics: no clock, no randomness but with a
fixed seed, and no input or output but posture banks.
"""

import controller.terms as cost_terms
from controller.collision.collision_model import CollisionModel, CollisionModels, PairKind
from controller.collision.self_collision import SelfCollision
from controller.command import (
    Array,
    BaseGoal,
    Command,
    KinematicState,
    MotionGoal,
    PoseGoal,
    PostureGoal,
    after,
)
from controller.controller import HolisticController
from controller.limits import Constraints, Limit
from controller.model import RobotModel, manipulability, robot_model
from controller.servo import pose_error
from controller.settings import PAPER, PRESETS, ControllerSettings
from controller.situation import Situation, linearise
from controller.stance.dexterity import (
    SEED,
    dexterity,
    manipulabilities,
    stance_margins,
    uniform_postures,
)
from controller.stance.finder import StanceFinder, stance_search, why_no_stance
from controller.stance.free_space import se3_of
from controller.stance.posture_bank import PostureBank, bank
from controller.stance.reach import farthest, out_of_reach, reached_instead
from controller.stance.stance import (
    REACHED,
    Stance,
    refine,
    refine_standing,
    unwound,
)
from controller.stance.tool_poses import forward_kinematics
from controller.step_report import StepReport
from controller.surroundings import OPEN_FLOOR, Obstacle, PointCloud, Surroundings
from controller.terms import PAPER_TERMS, STANDARD_TERMS, Aim, Cost, Term
from controller.validation import GoalError, is_rotation
from controller.velocity_bounds import VelocityBounds
