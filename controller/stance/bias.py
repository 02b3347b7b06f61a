"""How strongly base and arm are led to a stance, and how fast: what the guidance adds to the QP.

Far from the goal the base is led to where it will stand and the arm to the posture it will have;
near the goal the end effector takes over. The two are blended in one QP by their weights.
"""

from __future__ import annotations

from math import cos, hypot, inf, sin
from typing import NamedTuple

import numpy as np

from controller.command import Array, PoseGoal
from controller.floor import Lead, Pose2D, drive_along
from controller.model import RobotModel
from controller.settings import ControllerSettings, GuidanceSettings
from controller.stance.moving_goal import MIN_TRACKING, elbow_upright, follow_weight


class StanceBias(NamedTuple):
    """What the guidance adds to one QP."""

    blend: float
    """s in [0, 1]: 0 leaves all to the end effector, 1 nearly all to base and arm."""
    min_tracking: float
    """Weight of the end effector's twist that is left at s = 1; 0 on a detour."""
    base_weight: float
    base_velocity: Array
    """(n_base,) of the base's degrees of freedom towards its place."""
    posture_weight: float
    joint_velocity: Array
    """(7,) towards the posture [rad/s]."""
    coasting: Array | None = None
    """(n_base,) velocity that the base has, of which this period's command changes a share; None
    takes the base for as fast as it is told."""
    response: float = 1.0
    """That share, in (0, 1]."""


class Remaining(NamedTuple):
    """What is left to do."""

    distance: float
    """Of the end effector to the goal, rotation included [m]."""
    base_target: Pose2D = Pose2D(0.0, 0.0, 0.0)
    """The base's place in the base frame."""
    lead: Lead | None = None
    """Where the base is led now on its way there."""
    joint_error: Array = np.zeros(7)
    """(7,) from the joint positions to the posture [rad]."""
    max_joint_error: float = 0.0
    """The largest of these [rad]."""
    joint_time: float = 0.0
    """Time that the joints take at full speed [s]."""
    carried: bool = False
    """Whether the posture is not that of the stance, but one to get there in."""
    docks: bool = False
    """Whether the base is led to where it will go straight in."""

    @property
    def base_time(self) -> float:
        """Least time for the base to get there [s]."""
        return 0.0 if self.lead is None else self.lead.time_left


def bias_towards(
    model: RobotModel,
    settings: ControllerSettings,
    remaining: Remaining,
    goal: PoseGoal,
    wTb: Pose2D,
    q: Array,
    *,
    detour: bool,
    following: Array | None = None,
) -> StanceBias:
    """The bias of one period towards a stance.

    Args:
        model: the robot.
        settings: of the controller; `guidance` is not None.
        remaining: what is left to do.
        goal: where the end effector is to be.
        wTb: base pose.
        q: (7,) joint positions [rad].
        detour: whether the end effector waits.
        following: (n_base,) velocity of a base that follows the goal instead of going to a place.
    """
    g = settings.guidance
    assert g is not None
    blend = _blend(g, remaining, detour)
    waits = detour or remaining.carried or remaining.docks
    base_weight, min_tracking = blend, 0.0 if waits else g.min_tracking * blend
    if goal.is_moving:
        min_tracking = MIN_TRACKING * blend
        base_weight = max(blend, follow_weight(remaining.distance))
    duration = max(
        1.0 / g.posture_rate,
        0.0 if remaining.carried else g.posture_time * min(remaining.base_time, _LONGEST_FOLD),
        remaining.joint_time / g.joint_speed,
    )
    posture_weight = g.posture_weight * max(blend, g.min_posture)
    joint_velocity = remaining.joint_error / duration
    if following is not None:
        posture_weight = g.posture_weight
        joint_velocity = joint_velocity * blend + (1.0 - blend) * _POSTURE_RATE * elbow_upright(q)
    return StanceBias(
        blend=blend,
        min_tracking=min_tracking,
        base_weight=g.base_weight * base_weight,
        base_velocity=(
            _base_velocity(model, settings, remaining, goal, wTb)
            if following is None
            else following
        ),
        posture_weight=posture_weight,
        joint_velocity=joint_velocity,
    )


_POSTURE_RATE = 1.0
_LONGEST_FOLD = 100.0
"""A base that does not know its time yet does not keep the arm from moving for ever [s]."""


def _blend(g: GuidanceSettings, remaining: Remaining, detour: bool) -> float:
    """s: how much is left to base and arm."""
    if (
        remaining.carried
        or remaining.docks
        or (remaining.lead is not None and not remaining.lead.final)
    ):
        return 1.0
    target = remaining.base_target
    blend = max(
        hypot(target.x, target.y) / g.fade_base,
        abs(target.heading) / g.fade_heading,
        remaining.max_joint_error / g.fade_joint,
    )
    near = (remaining.distance - g.fade_distance) / g.fade_length
    return min(1.0, blend, inf if detour else max(0.0, near))


def _base_velocity(
    model: RobotModel,
    settings: ControllerSettings,
    remaining: Remaining,
    goal: PoseGoal,
    wTb: Pose2D,
) -> Array:
    """(n_base,) towards the stance."""
    lead = remaining.lead
    assert lead is not None
    velocity = drive_along(model, settings, lead, max_speed=goal.speed)
    if goal.twist is not None:
        c, s = cos(wTb.heading), sin(wTb.heading)
        vx, vy = goal.twist[0], goal.twist[1]
        velocity += model.description.base.axes[:2].T @ [c * vx + s * vy, c * vy - s * vx]
    return velocity
