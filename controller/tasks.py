"""What each kind of motion goal asks of base and arm in one control period."""

from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from config.arrays import Array
from config.planar import Pose2D
from config.poses import MapPose
from controller.command import BaseGoal, PoseGoal, PostureGoal
from controller.floor.base_drive import drive_along
from controller.floor.route import plain_lead
from controller.guidance import Guidance
from controller.servo import Servo, approach_speed, error_norm, pose_error
from controller.situation import Situation
from controller.terms import Aim

_DECELERATION = 0.5  # towards a posture, as a share of the smallest joint acceleration limit
_DECAY = 0.9  # ratio of successive velocities of a robot that stops without a way to its goal
_NEAR = 0.1
"""Nearer to the goal of a straight motion than this the arm fully compensates for the lag of the
base, and not at all beyond twice this [m]."""
_LED = 0.5  # blend from which on the base follows the guidance


class Task(NamedTuple):
    """What was measured, as in `StepReport`, and what is to be done."""

    arrived: bool
    position_error: float
    orientation_error: float
    base_time: float = 0.0
    posture_error: float = 0.0
    unreachable: str = ""
    stance: Pose2D | None = None
    blend: float = 0.0
    detour: bool = False

    velocities: Array | None = None  # (n,) to come near to; None for the terms of the aim
    aim: Aim | None = None
    base_velocity: Array | None = None  # (n_base,) desired velocity of the base, if it is led


def rest_task(now: Situation) -> Task:
    """Base and arm come to rest."""
    return Task(False, np.nan, np.nan, velocities=np.zeros(now.model.n))


def posture_task(now: Situation, goal: PostureGoal) -> Task:
    """The arm to joint positions, all joints arriving together; the base comes to rest."""
    servo, limits = now.settings.servo, now.model.limits
    error = goal.q - now.state.q
    max_error = float(np.abs(error).max())
    deceleration = limits.qdd.min() * _DECELERATION
    speeds = [
        approach_speed(abs(e), servo.gain, deceleration, qd)
        for e, qd in zip(error, limits.qd, strict=True)
    ]
    duration = max(abs(e) / v if v > 0.0 else 0.0 for e, v in zip(error, speeds, strict=True))
    qd = error / duration if duration > 0.0 else np.zeros_like(error)
    velocities = np.concatenate([np.zeros(now.model.n_base), qd])
    arrived = max_error <= goal.tolerance
    return Task(arrived, 0.0, max_error, posture_error=max_error, velocities=velocities)


def base_task(now: Situation, goal: BaseGoal[MapPose], guidance: Guidance | None) -> Task:
    """The base to a pose; the arm comes to rest."""
    model, error = now.model, pose_error(SE3.Identity(), now.state.mTb.inverse() * goal.target)
    if guidance is None:
        lead = plain_lead(model, now.base, Pose2D.of(goal.target), goal.reverse)
    else:
        lead = guidance.lead_base(goal, now.base, now.surroundings)
    base = drive_along(model, now.settings, lead, goal.speed)
    return Task(
        error.within(goal.position_tolerance, goal.heading_tolerance),
        error.position,
        error.orientation,
        base_time=lead.time_left,
        unreachable=lead.unreachable,
        velocities=np.concatenate([base, np.zeros(model.n_arm)]),
        base_velocity=base,
    )


def pose_task(
    now: Situation, goal: PoseGoal[MapPose], servo: Servo, guidance: Guidance | None, last: Array
) -> Task:
    """Base and arm together to an end-effector pose.

    `last` (n,) are the velocities of the last period without compensation of the base's lag.
    """
    goal = servo.with_motion(goal, now.surroundings.mTo)
    bTe, bTm = now.kinematics.bTe, now.state.mTb.inverse()
    error = pose_error(bTe, bTm * goal.target)
    arrived = error.within(goal.position_tolerance, goal.orientation_tolerance)
    twist = servo(goal, bTm, bTe, error)
    norm = error_norm(now.settings, bTe, error)
    if guidance is None:
        aim = Aim(goal, twist, norm, last, goal.base_rests)
        return Task(arrived, error.position, error.orientation, aim=aim)
    guided = guidance.step(goal, error, now.base, now.state.q, now.surroundings)
    bias = guided.bias
    if goal.next_goal is None:
        guidance.departure.reset()
    elif bias is None:
        m, lag, q = now.kinematics.manipulability, now.lag, now.state.q
        bias = guidance.departure.bias(goal.next_goal, error.position, m, lag, now.base, q)
    alone = goal.straight and bias is None and not guidance.rests
    compensates = max(0.0, min(1.0, 2.0 - error.position / _NEAR)) if alone else 0.0
    aim = Aim(goal, twist, norm, last, goal.base_rests, guided.bearing, bias, compensates)
    blend = 0.0 if bias is None else bias.blend
    return Task(
        arrived,
        error.position,
        error.orientation,
        *guided.remaining,
        guidance.unreachable,
        guided.base,
        blend,
        guidance.detour,
        _DECAY * now.applied if guidance.rests else None,
        aim,
        bias.base_velocity if bias is not None and blend >= _LED else None,
    )
