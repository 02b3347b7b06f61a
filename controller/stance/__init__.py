"""Stances of base and arm for a goal: search, approach, and following of moving goals."""

from typing import TYPE_CHECKING

from config import lazy_face

if TYPE_CHECKING:
    from controller.stance.approach import Approach
    from controller.stance.bias import Remaining, StanceBias, bias_towards
    from controller.stance.finder import StanceFinder, out_of_reach
    from controller.stance.free_space import se3_of
    from controller.stance.moving_goal import MovingGoalFollower
    from controller.stance.next_goal import NextGoalApproach
    from controller.stance.posture_bank import PostureBank, bank
    from controller.stance.search import StanceSearch
    from controller.stance.stance import REACHED, Stance, refine_standing
else:
    __getattr__ = lazy_face(__name__)

__all__ = [
    "REACHED",
    "Approach",
    "MovingGoalFollower",
    "NextGoalApproach",
    "PostureBank",
    "Remaining",
    "Stance",
    "StanceBias",
    "StanceFinder",
    "StanceSearch",
    "bank",
    "bias_towards",
    "out_of_reach",
    "refine_standing",
    "se3_of",
]
