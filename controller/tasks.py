"""Tasks of the QP: what each kind of motion goal asks of base and arm in one control period."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from pinocchio import SE3

from controller.command import Array, BaseGoal, KinematicState, MotionGoal, PoseGoal, PostureGoal
from controller.floor.base_drive import Pose2D, drive_along
from controller.floor.route import plain_lead
from controller.guidance import Guidance
from controller.holistic_qp import Linearisation, build_qp
from controller.model import Lag, RobotModel
from controller.qp_solver import QP
from controller.servo import Servo, approach_speed, error_norm, pose_error
from controller.settings import ControllerSettings
from controller.surroundings import Surroundings

_DECAY = 0.9  # ratio of successive velocities of a robot that stops without a way to its goal
_NEAR = 0.1
"""Nearer to the goal of a straight motion than this the arm fully compensates for the lag of the
base, and not at all beyond twice this [m]."""
_MIN_SURPLUS = 0.001  # smaller velocities of the lagging base are not compensated [m/s and rad/s]
_LED = 0.5  # blend from which on the base follows the guidance


class Tick(NamedTuple):
    """Inputs of one control period."""

    state: KinematicState
    base: Pose2D
    goal: MotionGoal | None
    applied: Array  # (n,) velocities of the last period
    bounds: tuple[Array, Array]  # lower and upper bounds (n,) of the velocities
    kinematics: Linearisation
    surroundings: Surroundings


class Task(NamedTuple):
    """The QP of a motion goal, and what was measured about the goal."""

    qp: QP
    measured: dict[str, Any]  # what its report says about the goal
    twist: Array | None = None  # (6,) desired end-effector twist in base axes, if there is one
    base_velocity: Array | None = None  # (n_base,) desired velocity of the base, if it is led
    lag_compensation: Callable[[Array], QP | None] = lambda base: None
    """From base velocities (n_base,) to the QP in which the arm compensates for the base's lag."""


def rest_task(tick: Tick) -> Task:
    """Base and arm come to rest."""
    measured = {"arrived": False, "position_error": np.nan, "orientation_error": np.nan}
    return Task(_qp_towards(np.zeros(len(tick.applied)), tick), measured)


def posture_task(
    model: RobotModel, settings: ControllerSettings, tick: Tick, goal: PostureGoal
) -> Task:
    """The arm to joint positions, all joints arriving together; the base comes to rest."""
    servo, limits = settings.servo, model.limits
    error = goal.q - tick.state.q
    max_error = float(np.abs(error).max())
    deceleration = limits.qdd.min() * servo.joint_deceleration
    speeds = [
        approach_speed(abs(e), servo.gain, deceleration, qd)
        for e, qd in zip(error, limits.qd, strict=True)
    ]
    duration = max(abs(e) / v if v > 0.0 else 0.0 for e, v in zip(error, speeds, strict=True))
    qd = error / duration if duration > 0.0 else np.zeros_like(error)
    measured = {
        "arrived": max_error <= goal.tolerance,
        "position_error": 0.0,
        "orientation_error": max_error,
        "posture_error": max_error,
    }
    return Task(_qp_towards(np.concatenate([np.zeros(model.n_base), qd]), tick), measured)


def base_task(
    model: RobotModel,
    settings: ControllerSettings,
    guidance: Guidance | None,
    tick: Tick,
    goal: BaseGoal,
) -> Task:
    """The base to a pose; the arm comes to rest."""
    error = pose_error(SE3.Identity(), tick.state.wTb.inverse() * goal.wTb)
    if guidance is None:
        lead = plain_lead(model, tick.base, Pose2D.of(goal.wTb), goal.reverse)
    else:
        lead = guidance.lead_base(goal, tick.base, tick.surroundings)
    base = drive_along(model, settings, lead, goal.speed)
    measured = {
        "arrived": error.position <= goal.position_tolerance
        and error.orientation <= goal.heading_tolerance,
        "position_error": error.position,
        "orientation_error": error.orientation,
        "base_time": lead.time_left,
        "unreachable": lead.unreachable,
    }
    qp = _qp_towards(np.concatenate([base, np.zeros(len(tick.state.q))]), tick)
    return Task(qp, measured, base_velocity=base)


class PoseTask:
    """Base and arm together to end-effector poses; keeps servo and guidance between periods."""

    def __init__(
        self,
        model: RobotModel,
        settings: ControllerSettings,
        guidance: Guidance | None,
        lag: Lag,
    ) -> None:
        self._model, self._settings = model, settings
        self._guidance, self._lag = guidance, lag
        self._servo = Servo(settings, model.description.arm.lag)

    def reset(self, goal: MotionGoal | None) -> None:
        """Forget the last pose goal, in a period with another kind of goal."""
        if self._guidance is not None:
            self._guidance.reset(keeps_bearing=not isinstance(goal, PostureGoal))
        self._servo.reset()

    def __call__(self, tick: Tick, goal: PoseGoal, steady: Array) -> Task:
        """The task of one period; `steady` (n,) are the last velocities without compensation."""
        model, settings, guidance = self._model, self._settings, self._guidance
        bTe, J, bounds = tick.kinematics.bTe, tick.kinematics.J, tick.bounds
        goal = self._servo.with_motion(goal, tick.surroundings.wTo)
        bTw = tick.state.wTb.inverse()
        error = pose_error(bTe, bTw * goal.wTe)
        twist = self._servo(goal, bTw, bTe, error)
        norm = error_norm(settings, bTe, error)
        measured: dict[str, Any] = {
            "arrived": error.position <= goal.position_tolerance
            and error.orientation <= goal.orientation_tolerance,
            "position_error": error.position,
            "orientation_error": error.orientation,
        }
        bias, bearing, near = None, 0.0, min(1.0, 2.0 - error.position / _NEAR)
        if guidance is not None:
            bias = guidance.bias(goal, error, tick.base, tick.state.q, tick.surroundings)
            bearing = guidance.bearing
            measured["base_time"], measured["posture_error"] = guidance.remaining
            measured["unreachable"] = guidance.unreachable
            measured["stance"], measured["detour"] = guidance.base, guidance.detour
            if goal.next_goal is None:
                guidance.next_goal.reset()
            elif bias is None:
                m, lag = tick.kinematics.manipulability, self._lag
                bias = guidance.next_goal.bias(
                    goal.next_goal, error.position, m, lag, tick.base, tick.state.q
                )
        measured["blend"] = 0.0 if bias is None else bias.blend
        qp = build_qp(
            model,
            settings,
            tick.kinematics,
            twist,
            norm,
            bounds,
            steady,
            bias,
            bearing,
            base_rests=goal.base_rests,
        )
        compensates = guidance is not None and goal.straight and bias is None and near > 0.0
        if guidance is not None and guidance.rests:
            qp, compensates = _qp_towards(_DECAY * tick.applied, tick), False

        def lag_compensation(base: Array) -> QP | None:
            if not compensates:
                return None
            surplus = near * self._lag.surplus(base)
            if np.abs(surplus).max() < _MIN_SURPLUS:
                return None
            late = twist - J[:, : model.n_base] @ surplus
            lower, upper = bounds[0].copy(), bounds[1].copy()
            lower[: len(base)] = upper[: len(base)] = base
            fixed = lower, upper
            return build_qp(model, settings, tick.kinematics, late, norm, fixed, tick.applied)

        led = None if bias is None or bias.blend < _LED else bias.base_velocity
        return Task(qp, measured, twist, led, lag_compensation)


def _qp_towards(velocities: Array, tick: Tick) -> QP:
    """The QP whose minimiser is nearest to velocities (n,)."""
    return QP(np.eye(len(velocities)), -velocities, *tick.bounds)
