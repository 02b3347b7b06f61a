"""Where base and arm stand for a goal: finding a stance, heading for it, following with it."""

from controller.stance.approach import Approach
from controller.stance.bias import Remaining, StanceBias, bias_towards
from controller.stance.finder import StanceFinder
from controller.stance.following import Follower
from controller.stance.reachability import out_of_reach
from controller.stance.search import StanceSearch
from controller.stance.stance import Stance

__all__ = [
    "Approach",
    "Follower",
    "Remaining",
    "Stance",
    "StanceBias",
    "StanceFinder",
    "StanceSearch",
    "bias_towards",
    "out_of_reach",
]
