"""Why a robot cannot get its hand to a goal, in words."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from pinocchio import SE3

from controller.command import Array, PoseGoal
from controller.stance.free_space import FreeSpace
from controller.stance.posture_bank import BANK, PostureBank, forward_kinematics
from controller.stance.search import StanceSearch
from robots import RobotDescription

_SAME_TILT = 0.96
"""Postures whose vertical is this near to the goal's are tilted like it (a cosine)."""
_BANK_GAP = 0.25
"""The bank's highest and lowest postures of any tilt are not this far from the arm's own [m]."""
_FEW_GAP = 0.3
"""The same for a quarter of the bank [m]."""
_UNREACHED = 0.02
"""Height and tilt that are left to the best refined posture of a goal that cannot be reached [m +
rad]; postures of goals that can be come within a thousandth."""
_INSIDE = 0.01
"""A hand that is deeper in something is inside, not a little too near [m] ..."""
_INSIDE_STRAIGHT = 0.03
"""... and where it goes straight: its shapes reach beyond the finger tips [m]."""
_SPOKEN = {"link7": "the wrist", "held": "what the hand holds"}


def obstacle_to(goal: PoseGoal, bank: PostureBank, space: FreeSpace | None) -> str:
    """What is wrong with a goal wherever the robot stands; empty if nothing is.

    Args:
        goal: where the end effector is to be.
        bank: the robot's postures.
        space: what stands around; None on an open floor.
    """
    height = float(goal.wTe.translation[2])
    if height < -_INSIDE - goal.position_tolerance:
        return f"{-height:.2f} m below the floor"
    low, high = heights_in_tilt(bank, goal.wTe.rotation[2])
    if height > high + _BANK_GAP or height < low - _BANK_GAP:
        return _out_of_reach(height, low, high)
    if space is None or goal.hand_may_touch:
        return ""
    hand = space.hand_at(goal.wTe)
    if hand.distance > -(_INSIDE_STRAIGHT if goal.straight else _INSIDE):
        return ""
    if fixture := space.around(goal.wTe.translation):
        return f"inside {fixture}"
    part = _SPOKEN.get(hand.part, f"the {hand.part}")
    return f"{part} would be inside {hand.fixture}"


def out_of_reach(robot: RobotDescription, wTe: SE3) -> str:
    """Why the hand cannot have a height and tilt wherever the base stands; empty if it can.

    Quick, for checks before a robot moves: it looks at a few of the bank's postures.
    """
    height, (low, high) = float(wTe.translation[2]), heights_in_tilt(_few(robot), wTe.rotation[2])
    inside = low - _FEW_GAP <= height <= high + _FEW_GAP
    return "" if inside else _out_of_reach(height, low, high)


@lru_cache(maxsize=4)
def _few(robot: RobotDescription) -> PostureBank:
    q = np.load(BANK)[::4].astype(float)
    q = q[((robot.limits.q_min <= q) & (q <= robot.limits.q_max)).all(axis=1)]
    return PostureBank(q, forward_kinematics(robot, q))


def why_no_stance(search: StanceSearch, bank: PostureBank) -> str:
    """Why a search that is over has found no stance; empty if what it has found will do."""
    if _UNREACHED < search.error < np.inf:
        height = float(search.wTe.translation[2])
        return _out_of_reach(height, *heights_in_tilt(bank, search.wTe.rotation[2]))
    if search.best is not None:
        return ""
    if search.base_stands and not search.base_gets_there:
        return "no way for the base"
    return f"no stance stands free of {search.blocked}"


def heights_in_tilt(bank: PostureBank, vertical: Array) -> tuple[float, float]:
    """Lowest and highest place of the hand [m] that sees the world's vertical (3,) like this."""
    alike = np.flatnonzero(bank.tools.rotations[:, 2] @ vertical > _SAME_TILT)
    if len(alike) == 0:
        return np.inf, -np.inf
    heights = bank.tools.positions[alike, 2]
    return float(heights.min()), float(heights.max())


def _out_of_reach(height: float, low: float, high: float) -> str:
    if height > high:
        return f"{height:.2f} m up: tilted like this the hand reaches {high:.1f} m"
    if height < low:
        return f"{height:.2f} m up: tilted like this the hand reaches down to {low:.1f} m"
    return f"{height:.2f} m up: the arm has no posture of that height and tilt"
