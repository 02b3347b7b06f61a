"""Position-based servoing: the desired end-effector twist towards a pose goal.

The velocity of a moving goal is estimated from successive goals. Position and orientation each have
a fading-memory filter of the second order (the critically damped alpha-beta filter; Morrison,
"Introduction to Sequential Smoothing and Prediction", 1969). A goal that jumps is a new goal, and
one that jitters, as detected anew in every frame, is at rest.
"""

from dataclasses import replace
from math import atan2, exp, inf, sqrt
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from config.poses import MapFromOdometry, MapPose, Pose
from controller.command import Array, PoseGoal
from controller.settings import ControllerSettings, ServoSettings

_MEMORY = 0.1  # time constant of the filters: the velocity lags by twice this [s]
_JUMP, _TURN = 0.008, 0.03
"""A change in one period that differs from the one before by more than this is a jump [m, rad]."""
_STILL, _STILL_TURN = 0.02, 0.06
"""A velocity below this counts as 0, and one above twice this fully [m/s, rad/s]."""
_REST = 1e-9  # smaller filter states count as 0 [m, rad and per second]


class GoalVelocity:
    """Adds an estimated twist to goals without one; `period` is the control period [s]."""

    def __init__(self, period: float) -> None:
        self._period = period
        self.reset()

    def reset(self) -> None:
        """Forget the goal; the next one is at rest."""
        self._last: SE3 | None = None
        self._rests: object = None  # the goal, if it need not be looked at again
        self._settled = False  # whether the goal is at rest and the filters have converged
        self._linear = _Filter(self._period, _JUMP, _STILL)
        self._angular = _Filter(self._period, _TURN, _STILL_TURN)

    def __call__(self, goal: PoseGoal[Pose]) -> PoseGoal[Pose]:
        """The goal with its estimated twist, unless it has one or is at rest."""
        if goal is self._rests:
            return goal
        last = self._last
        stands = last is not None and goal.target == last
        if stands and (self._settled or goal.twist is not None):
            self._rests = goal
            return goal
        self._rests = None
        self._last = goal.target.copy()
        if last is None or goal.twist is not None:
            return goal
        linear = self._linear(goal.target.translation - last.translation)
        angular = self._angular(pin.log3(goal.target.rotation @ last.rotation.T))
        self._settled = stands and self._linear.at_rest and self._angular.at_rest
        if linear is None and angular is None:
            return goal
        nothing = np.zeros(3)
        twist = [nothing if part is None else part for part in (linear, angular)]
        return replace(goal, twist=np.concatenate(twist))


class _Filter:
    """Rate (3,) of three numbers from their changes (3,) per period."""

    def __init__(self, period: float, jump: float, still: float) -> None:
        fading = exp(-period / _MEMORY)
        self._position_gain = 1.0 - fading * fading
        self._rate_gain = (1.0 - fading) ** 2 / period
        self._period, self._jump, self._still = period, jump, still
        self._last_change = np.zeros(3)
        self._forget()

    def _forget(self) -> None:
        self._behind = np.zeros(3)  # error of the filtered position
        self._rate = np.zeros(3)
        self.at_rest = True  # whether the filter has converged to rest

    def __call__(self, change: Array) -> Array | None:
        size, unlike = _length(change), _length(change - self._last_change)
        self._last_change = change
        if unlike > self._jump:
            self._forget()
        elif size > _REST or not self.at_rest:
            innovation = self._behind + change - self._rate * self._period
            self._rate = self._rate + self._rate_gain * innovation
            self._behind = (1.0 - self._position_gain) * innovation
            self.at_rest = max(_length(self._rate), _length(self._behind)) < _REST
        share = _length(self._rate) / self._still - 1.0
        return self._rate * min(1.0, share) if share > 0.0 else None


_STRAIGHT_GAIN = 6.0
"""Both gains for straight motion with guidance, where the arm compensates for the lag of the base
[1/s]."""
_STRAIGHT_STEADYING = 0.04  # time constant of the filter for that [s]
_GAIN_LAG = 0.6  # largest product of gain and lag: the phase margin of pure lag is then 55 deg
_NEAR, _NEAR_ANGLE = 0.04, 0.14
"""Error below which the twist is low-pass filtered, fully at half of this [m and rad]."""


class PoseError(NamedTuple):
    """Error between two poses."""

    position: float  # distance [m]
    orientation: float  # angle of the rotation between them [rad]
    translation_vector: Array  # (3,) in the axes that both poses are expressed in [m]
    rotation_vector: Array  # (3,) axis times angle, in the same axes [rad]

    def within(self, position: float, orientation: float) -> bool:
        """Whether it is within tolerances [m, rad]."""
        return self.position <= position and self.orientation <= orientation


def pose_error(current: SE3, target: SE3) -> PoseError:
    """The translation and rotation from one pose to another, both in the same frame."""
    translation = target.translation - current.translation
    rotation = pin.log3((target * current.inverse()).rotation)
    return PoseError(_length(translation), _length(rotation), translation, rotation)


def error_norm(settings: ControllerSettings, bTe: SE3, error: PoseError) -> float:
    """|e| of the weights of the QP [m]."""
    if settings.error_norm == "euclidean":
        return error.position
    return float(np.abs(bTe.rotation.T @ error.translation_vector).sum())


class Servo:
    """Computes the desired twist in every period; keeps the goal's velocity and the last twist.

    Without guidance, as published, goal velocities are not estimated and straight motion has no
    gains of its own.
    """

    def __init__(self, settings: ControllerSettings, lag: float) -> None:
        servo, self._period = settings.servo, settings.period
        self._estimates_motion = settings.guidance
        gain = _STRAIGHT_GAIN
        straight = replace(servo, gain=gain, rotation_gain=gain, steadying=_STRAIGHT_STEADYING)
        servo, straight = (_steady(one, lag) for one in (servo, straight))
        self._plain, self._straight = servo, straight if self._estimates_motion else servo
        self.reset()

    def reset(self) -> None:
        """Forget the goal."""
        self._goal_motion = GoalVelocity(self._period)
        self._in_odometry = GoalVelocity(self._period)
        self._last = np.zeros(6)

    def with_motion(
        self, goal: PoseGoal[MapPose], mTo: MapFromOdometry | None
    ) -> PoseGoal[MapPose]:
        """The goal with its estimated twist, unless it has one or is at rest.

        A correction of the localisation is no motion: a goal that rests on the map or in the
        odometry, which is at `mTo`, is at rest.
        """
        if not self._estimates_motion:
            return goal
        found = self._goal_motion(goal)
        if mTo is None or found.twist is None:
            return found
        return goal if self._in_odometry(goal.in_odometry(mTo)).twist is None else found

    def __call__(self, goal: PoseGoal[MapPose], bTm: SE3, bTe: SE3, error: PoseError) -> Array:
        """The twist ν (6,) towards a goal, with the goal's own, in base axes [m/s, rad/s].

        Near the goal the twist is low-pass filtered, as most of the error is state noise there.
        `error` is from `bTe` to the goal, in base axes.
        """
        settings = self._straight if goal.straight else self._plain
        steadying = settings.steadying
        twist = desired_twist(settings, goal, bTm, bTe, error)
        far = max(error.position / _NEAR, error.orientation / _NEAR_ANGLE)
        if far < 1.0 and steadying > 0.0:
            memory = exp(-self._period / steadying) * min(1.0, 2.0 * (1.0 - far))
            twist += memory * (self._last - twist)
        self._last = twist
        if goal.twist is None:
            return twist
        R = bTm.rotation
        return np.concatenate([twist[:3] + R @ goal.twist[:3], twist[3:] + R @ goal.twist[3:]])


def _steady(servo: ServoSettings, lag: float) -> ServoSettings:
    """The same with gains at which an arm that follows late [s] does not swing."""
    gain, rotation_gain = (min(one, _GAIN_LAG / lag) for one in (servo.gain, servo.rotation_gain))
    return replace(servo, gain=gain, rotation_gain=rotation_gain)


def desired_twist(
    settings: ServoSettings, goal: PoseGoal[MapPose], bTm: SE3, bTe: SE3, error: PoseError
) -> Array:
    """The twist ν (6,) towards a goal at rest, in base axes (Haviland 2022, eq. 17) [m/s, rad/s].

    Proportional to the error near the goal; with a finite deceleration the speed is limited by
    `approach_speed`. `error` is from `bTe` to the goal, in base axes.
    """
    rotation = error.rotation_vector
    if settings.rotation_error == "roll pitch yaw":
        R = bTe.rotation
        rotation = R @ _roll_pitch_yaw(R.T @ bTm.rotation @ goal.target.rotation)
    gain, rotation_gain = settings.gain, settings.rotation_gain
    if settings.deceleration < inf:
        distance, angle = error.position, error.orientation
        speed = approach_speed(distance, gain, settings.deceleration, goal.speed)
        rate = approach_speed(angle, rotation_gain, settings.turn_deceleration, goal.turn_rate)
        gain = speed / distance if distance > 0.0 else 0.0
        rotation_gain = rate / angle if angle > 0.0 else 0.0
    linear = [gain * x for x in error.translation_vector.tolist()]
    return np.array(linear + [rotation_gain * x for x in rotation.tolist()])


def approach_speed(distance: float, gain: float, deceleration: float, max_speed: float) -> float:
    """Speed at a distance to the goal (not negative) from which the robot can still brake in time.

    Proportional with `gain` [1/s] near the goal (Haviland 2022, eq. 17), then the square root of a
    constant deceleration, joined where their slopes agree, and at most `max_speed`.
    """
    transition = deceleration / (gain * gain)
    if distance <= transition:
        return min(gain * distance, max_speed)
    return min(sqrt(2.0 * deceleration * (distance - transition / 2.0)), max_speed)


def _length(vector: Array) -> float:
    x, y, z = vector.tolist()
    return sqrt(x * x + y * y + z * z)


def _roll_pitch_yaw(R: Array) -> Array:
    """Roll, pitch and yaw (3,) of a rotation, R = Rz(yaw) Ry(pitch) Rx(roll) [rad]."""
    pitch = atan2(-R[2, 0], sqrt(R[0, 0] ** 2 + R[1, 0] ** 2))
    return np.array([atan2(R[2, 1], R[2, 2]), pitch, atan2(R[1, 0], R[0, 0])])
