"""Stance bias: the terms that guidance adds to the QP.

Far from the goal base and arm are led to the stance, near the goal the end effector takes over; the
weights of one QP blend the two.
"""

from math import cos, hypot, inf, sin
from typing import NamedTuple

import numpy as np

from controller.command import Array, PoseGoal
from controller.floor.base_drive import Lead, Pose2D, drive_along
from controller.model import RobotModel
from controller.settings import ControllerSettings, GuidanceSettings
from controller.stance.moving_goal import MIN_TRACKING, elbow_upright, follow_weight


class StanceBias(NamedTuple):
    """Terms of one QP towards a stance."""

    blend: float  # s in [0, 1]: 0 leaves the motion to the end effector, 1 to base and arm
    min_tracking: float  # weight of the end-effector twist at s = 1; 0 on a detour
    base_weight: float
    base_velocity: Array  # (n_base,) towards the base pose
    posture_weight: float
    pull: Array  # (n,) wanted velocities of base and joints times their weights
    coasting: Array | None = None  # (n_base,) present velocity of a lagging base; None without lag
    response: float = 1.0  # share of a commanded change that the base takes up, in (0, 1]


class Remaining(NamedTuple):
    """Remaining motion to a goal and its stance."""

    distance: float  # of the end effector to the goal, rotation included [m]
    base_target: Pose2D = Pose2D(0.0, 0.0, 0.0)  # base pose of the stance in the base frame
    lead: Lead | None = None  # where the base is led now
    joint_error: Array | None = None  # (j,) from the joint positions to the posture [rad]
    max_joint_error: float = 0.0  # the largest of these [rad]
    joint_time: float = 0.0  # time of the joints at full speed [s]
    in_transport: bool = False  # whether the posture is the transport posture
    docks: bool = False  # whether the base is led to the dock

    @property
    def base_time(self) -> float:
        """Least time of the base to the stance [s]."""
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

    `q` are (j,) joint positions [rad]; on a `detour` the end effector waits; `following` is the
    (n_base,) velocity of a base that follows a moving goal.
    """
    g = settings.guidance
    assert g is not None
    blend = _blend(g, remaining, detour)
    waits = detour or remaining.in_transport or remaining.docks
    base_weight, min_tracking = blend, 0.0 if waits else g.min_tracking * blend
    if goal.is_moving:
        min_tracking = MIN_TRACKING * blend
        base_weight = max(blend, follow_weight(remaining.distance))
    duration = max(
        1.0 / g.posture_rate,
        0.0 if remaining.in_transport else g.posture_time * min(remaining.base_time, _LONGEST_FOLD),
        remaining.joint_time / g.joint_speed,
    )
    base_weight *= g.base_weight
    slowness = _FAST * remaining.joint_time / max(remaining.max_joint_error, 1e-9)
    slowness = min(max(1.0, slowness), _SLOWEST)
    posture_weight = slowness * g.posture_weight * max(blend, g.min_posture)
    assert remaining.joint_error is not None
    joint_velocity = remaining.joint_error / duration
    if following is not None:
        posture_weight = g.posture_weight
        upright = _POSTURE_RATE * elbow_upright(model, q)
        joint_velocity = joint_velocity * blend + (1.0 - blend) * upright
        base_velocity = following
    else:
        base_velocity = _base_velocity(model, settings, remaining, goal, wTb)
    return StanceBias(
        blend=blend,
        min_tracking=min_tracking,
        base_weight=base_weight,
        base_velocity=base_velocity,
        posture_weight=posture_weight,
        pull=np.concatenate([base_weight * base_velocity, posture_weight * joint_velocity]),
    )


_POSTURE_RATE = 1.0
_FAST, _SLOWEST = 2.0, 4.0
"""A posture draws an arm that is slower than this so much more, at most by this factor, that hand
and manipulability do not hold it back [rad/s]."""
_LONGEST_FOLD = 100.0  # largest time that the arm adapts to; infinite without a path [s]


def _blend(g: GuidanceSettings, remaining: Remaining, detour: bool) -> float:
    """s: share of the motion that is led by the stance."""
    if (
        remaining.in_transport
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
