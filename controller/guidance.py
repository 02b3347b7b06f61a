"""The way out of local minima: towards a stance that is known to reach the goal.

Far from the goal the base is led to where it will stand and the arm to the posture it will have;
near the goal the end effector takes over. The two are blended in one QP by their weights.
"""

from __future__ import annotations

from math import cos, hypot, inf, sin
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from controller.base_drive import Pose2D, drive_to, time_to_drive
from controller.command import Array, PoseGoal
from controller.following import MIN_TRACKING, follow, follow_weight
from controller.model import RobotModel
from controller.postures import bank
from controller.self_collision import SelfCollision
from controller.servo import PoseError
from controller.settings import ControllerSettings
from controller.stance import Stance, choose_stance


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


class _Remaining(NamedTuple):
    """What is left to do."""

    distance: float
    """Of the end effector to the goal, rotation included [m]."""
    base_target: Pose2D
    """The base's place in the base frame."""
    base_time: float
    """Least time for the base to get there [s]."""
    joint_error: Array
    """(7,) from the joint positions to the posture [rad]."""
    max_joint_error: float
    """The largest of these [rad]."""
    joint_time: float
    """Time that the joints take at full speed [s]."""


class Guide:
    """Keeps the stance of one goal from period to period.

    Args:
        model: the robot.
        settings: of the controller; `guidance` is not None.
        collision: the robot's shapes.
    """

    def __init__(
        self, model: RobotModel, settings: ControllerSettings, collision: SelfCollision
    ) -> None:
        self._model = model
        self._settings = settings
        assert settings.guidance is not None
        self._guidance = settings.guidance
        self._collision = collision
        self._bank = bank(model.description)
        self._min_turn_cosine = cos(self._guidance.goal_turn)
        self.reset()

    def reset(self) -> None:
        """Forget the goal: the next one is new."""
        self.left = (0.0, 0.0)
        """What the last step left of the way to the stance: least time of the base [s] and largest
        joint error [rad]; both 0 without a stance."""
        self._goal: SE3 | None = None
        self._first_goal: SE3 | None = None
        self._start_goal(None)
        self._set_stance(None)

    def _start_goal(self, wTe: SE3 | None) -> None:
        self._first_goal = wTe
        self._failed: tuple[Stance, ...] = ()
        self._detours_left = self._guidance.detours

    def _set_stance(self, stance: Stance | None, detour: bool = False) -> None:
        self._stance = stance
        self._detour = detour
        self._best = (inf, inf, inf)
        self._waited = 0

    def bias(self, goal: PoseGoal, error: PoseError, wTb: Pose2D, q: Array) -> StanceBias | None:
        """Velocities towards the goal's stance; None if the end effector goes alone.

        Args:
            goal: where the end effector is to be.
            error: of the end effector.
            wTb: base pose.
            q: (7,) joint positions [rad].
        """
        g = self._guidance
        distance = error.position + g.metres_per_radian * error.orientation
        if goal.wTe != self._goal:
            if self._is_new(goal.wTe):
                self._start_goal(goal.wTe.copy())
                guided = distance > g.min_distance and not goal.straight
                self._set_stance(self._choose(goal, wTb, q) if guided else None)
            self._goal = goal.wTe.copy()
        remaining = self._remaining(goal, distance, wTb, q)
        if self._has_stalled(remaining, goal) and not goal.straight and self._detours_left:
            self._detours_left -= 1
            if self._stance is not None:
                self._failed = (*self._failed, self._stance)
            self._set_stance(self._choose(goal, wTb, q) if self._detours_left else None, True)
            remaining = self._remaining(goal, distance, wTb, q)
        self.left = (remaining.base_time, remaining.max_joint_error)
        return None if self._stance is None else self._towards(self._stance, remaining, goal, wTb)

    def _choose(self, goal: PoseGoal, wTb: Pose2D, q: Array) -> Stance:
        model, settings = self._model, self._guidance.stance
        return choose_stance(
            model, settings, self._bank, self._collision, goal.wTe, wTb, q, failed=self._failed
        )

    def _is_new(self, wTe: SE3) -> bool:
        """Whether a goal has jumped, or crept to where its stance does not reach it."""
        if self._goal is None or self._first_goal is None:
            return True
        g = self._guidance
        moved = wTe.translation - self._goal.translation
        cosine = (float(np.vdot(wTe.rotation, self._goal.rotation)) - 1.0) / 2.0
        rise = float(wTe.translation[2] - self._first_goal.translation[2])
        tilt = float(wTe.rotation[2] @ self._first_goal.rotation[2])
        jumped = float(moved @ moved) > g.goal_jump * g.goal_jump or cosine < self._min_turn_cosine
        return jumped or abs(rise) > g.goal_rise or tilt < g.goal_tilt

    def _remaining(self, goal: PoseGoal, distance: float, wTb: Pose2D, q: Array) -> _Remaining:
        stance = self._stance
        if stance is None:
            return _Remaining(distance, Pose2D(0.0, 0.0, 0.0), 0.0, np.zeros(len(q)), 0.0, 0.0)
        target = stance.base_for(goal.wTe).relative_to(wTb)
        base_time = time_to_drive(self._model, self._settings.drive, target, stance.reverse)
        joint_error = stance.q - q
        size = np.abs(joint_error)
        joint_time = float((size / self._model.limits.qd).max())
        return _Remaining(distance, target, base_time, joint_error, float(size.max()), joint_time)

    def _has_stalled(self, remaining: _Remaining, goal: PoseGoal) -> bool:
        """Whether nothing has come nearer for a while: neither end effector, base nor arm.

        What follows a moving goal comes no nearer either, so it never stalls.
        """
        g = self._guidance
        if remaining.distance < g.close or goal.is_moving:
            self._set_stance(self._stance)
            return False
        distance, base_time, joint_error = self._best
        progress = max(
            distance - remaining.distance,
            base_time - remaining.base_time,
            joint_error - remaining.max_joint_error,
        )
        if progress > g.progress:
            self._best = (
                min(distance, remaining.distance),
                min(base_time, remaining.base_time),
                min(joint_error, remaining.max_joint_error),
            )
            self._waited = 0
        else:
            self._waited += 1
        return self._waited * self._settings.period >= g.patience

    def _towards(
        self, stance: Stance, remaining: _Remaining, goal: PoseGoal, wTb: Pose2D
    ) -> StanceBias:
        g, model, target = self._guidance, self._model, remaining.base_target
        blend = min(
            1.0,
            max(
                hypot(target.x, target.y) / g.fade_base,
                abs(target.heading) / g.fade_heading,
                remaining.max_joint_error / g.fade_joint,
            ),
        )
        if not self._detour:
            blend = min(blend, max(0.0, (remaining.distance - g.fade_distance) / g.fade_length))
        base_velocity, base_weight = self._lead_base(stance, target, goal, wTb), blend
        min_tracking = 0.0 if self._detour else g.min_tracking * blend
        if goal.is_moving:
            min_tracking = MIN_TRACKING * blend
            base_weight = max(blend, follow_weight(target.heading, remaining.distance))
        duration = max(
            1.0 / g.posture_rate,
            g.posture_time * remaining.base_time,
            remaining.joint_time / g.joint_speed,
        )
        return StanceBias(
            blend=blend,
            min_tracking=min_tracking,
            base_weight=g.base_weight * base_weight,
            base_velocity=base_velocity,
            posture_weight=g.posture_weight * max(blend, g.min_posture),
            joint_velocity=remaining.joint_error / duration,
        )

    def _lead_base(self, stance: Stance, target: Pose2D, goal: PoseGoal, wTb: Pose2D) -> Array:
        """Velocities of the base's degrees of freedom towards the stance."""
        model = self._model
        if goal.is_moving and model.n_base == 2:
            return follow(stance, goal, wTb)
        velocity = drive_to(
            model, self._settings, target, reverse=stance.reverse, max_speed=goal.speed
        )
        if goal.twist is not None:
            c, s = cos(wTb.heading), sin(wTb.heading)
            vx, vy = goal.twist[0], goal.twist[1]
            velocity += model.description.base.axes[:2].T @ [c * vx + s * vy, c * vy - s * vx]
        return velocity
