"""How a differential drive follows a goal that moves.

A stance is a place of the base relative to its goal. A base that cannot drive sideways does not
keep such a place while the goal turns or moves across: it has to turn first. So it is led like a
trailer by its hitch: the point of the base above which the stance holds the tool follows the goal,
and the heading follows from that. With a tool that keeps its yaw the heading must not drift too
far, or the arm winds up: the farther it is from that of the stance, the less the base is led.
"""

from __future__ import annotations

from math import cos, hypot, sin

import numpy as np

from controller.base_drive import Pose2D
from controller.command import Array, PoseGoal
from controller.stance import Stance

_GAIN = 0.5
"""Speed of the point towards its place under the goal, per distance [1/s]."""
_MIN_LEVER = 0.3
"""The point counts as at least this far ahead of the axle, so that the base does not spin [m]."""
_FREE_TURN = 1.0
"""Heading off that of the stance by less than this costs nothing [rad]; at twice this the base is
not led any longer."""
_WEIGHT = 1.5
"""Of the base's velocity in the QP when the tool has caught up ..."""
_CAUGHT_UP = 0.005
"""... to this [m]; it falls as 1/|e|, as the weight of the tool does."""
MIN_TRACKING = 4.0
"""Weight of the end effector's twist that is left at s = 1: a tool that cannot keep up stays
upright."""


def follow(stance: Stance, goal: PoseGoal, wTb: Pose2D) -> Array:
    """Velocities (2,) of a differential drive that follows a moving goal [rad/s, m/s]."""
    assert goal.twist is not None
    x, y, _ = stance.bTe.translation.tolist()
    gx, gy, _ = goal.wTe.translation.tolist()
    vx, vy = float(goal.twist[0]), float(goal.twist[1])
    at = Pose2D(gx, gy, 0.0).relative_to(wTb)
    c, s = cos(wTb.heading), sin(wTb.heading)
    ahead = c * vx + s * vy + _GAIN * (at.x - x)
    aside = c * vy - s * vx + _GAIN * (at.y - y)
    slower = min(1.0, goal.speed / max(hypot(ahead, aside), 1e-9))
    turning = slower * aside / max(x, _MIN_LEVER)
    return np.array([turning, slower * ahead + turning * y])


def follow_weight(turn: float, distance: float) -> float:
    """Weight of that velocity in the QP.

    Args:
        turn: from the base's heading to that of the stance [rad].
        distance: of the end effector to the goal, rotation included [m].
    """
    share = min(1.0, max(0.0, 2.0 - abs(turn) / _FREE_TURN))
    return _WEIGHT * share * _CAUGHT_UP / max(distance, _CAUGHT_UP)
