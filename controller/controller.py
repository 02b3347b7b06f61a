"""One step of control: from the state of the robot and its goal to velocities."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, sqrt
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from controller.base_drive import Pose2D, drive_to, time_to_drive
from controller.bounds import VelocityBounds
from controller.command import (
    Array,
    BaseGoal,
    Command,
    KinematicState,
    MotionGoal,
    PoseGoal,
    PostureGoal,
)
from controller.goal_motion import GoalMotion
from controller.guidance import Guide
from controller.holistic import Linearisation, build_qp, linearise
from controller.model import RobotModel
from controller.qp import QP, SOFT_PRECISION, Solver
from controller.self_collision import SelfCollision
from controller.servo import approach_speed, desired_twist, error_norm, pose_error
from controller.settings import ContactSettings, ControllerSettings
from controller.surroundings import OPEN_FLOOR, Surroundings
from controller.validation import check_inputs


@dataclass(frozen=True, kw_only=True, eq=False)
class StepReport:
    """What one control step measured and achieved."""

    arrived: bool
    """Whether the goal is reached within its tolerances; False without a goal."""
    position_error: float
    """Distance to the goal [m]; 0 for a posture, NaN without a goal."""
    orientation_error: float
    """Angle to the goal, for a posture the largest joint error [rad]; NaN without a goal."""
    manipulability: float
    """Yoshikawa's measure of the arm."""
    heading_error: float
    """θ_ε: bearing of the end effector seen from the base [rad]."""
    slack: float
    """|δ|: norm of the end-effector twist that was desired and not achieved [m/s and rad/s]."""
    solved: bool
    """Whether the QP was solved; if not, the command brakes."""
    bTe: SE3
    """End effector in the base."""
    base_time: float = 0.0
    """Least time in which the base gets to its goal, or to where the guidance wants it [s]; 0 where
    it has no place of its own to go to."""
    posture_error: float = 0.0
    """Largest joint error to the goal's posture, or to that of the guidance [rad]; 0 without."""
    unreachable: str = ""
    """Why the robot cannot get to the goal; empty if it can, as far as is known."""
    clearance: float = inf
    """Distance between the robot and what is nearest to it, if that is near [m]."""
    nearest: str = ""
    """What comes nearest to what, for people; empty if nothing is near."""


class _Motion(NamedTuple):
    """What one kind of goal asks for."""

    velocities: Array | None
    """(n,); None if the QP has no solution."""
    position_error: float = np.nan
    orientation_error: float = np.nan
    arrived: bool = False
    slack: float = 0.0
    base_time: float = 0.0
    posture_error: float = 0.0


class HolisticController:
    """Turns a goal into velocities of base and arm, one period at a time.

    Every returned command keeps the velocity, acceleration and joint position limits by
    construction: they are the bounds of the QP, and nothing is scaled after it.

    Args:
        model: the robot.
        settings: gains, weights and distances.
    """

    def __init__(self, model: RobotModel, settings: ControllerSettings | None = None) -> None:
        self.model = model
        self.settings = settings or ControllerSettings()
        self._bounds = VelocityBounds(model, self.settings)
        self._solver = Solver()
        self._soft_solver = Solver(SOFT_PRECISION)
        self._collision = SelfCollision(model)
        guided = self.settings.guidance is not None
        self._guide = Guide(model, self.settings, self._collision) if guided else None
        estimated = self.settings.servo.estimate_goal_motion
        self._goal_motion = GoalMotion(self.settings.period) if estimated else None

    def step(
        self,
        state: KinematicState,
        goal: MotionGoal | None,
        last: Command,
        surroundings: Surroundings = OPEN_FLOOR,
    ) -> tuple[Command, StepReport]:
        """The command for the next period.

        Args:
            state: where base and arm are.
            goal: where to go; None comes smoothly to rest.
            last: what the robot applied in the previous period.
            surroundings: what it must not hit.

        Raises:
            GoalError: a number in the state, the goal or the last command is not finite, or a
                pose has no rotation matrix.
        """
        check_inputs(state, goal, last)
        model, settings = self.model, self.settings
        velocities = model.velocities(last)
        bounds = self._bounds(state.q, velocities)
        linearisation = linearise(model, settings, state.q)
        if self._guide is not None and not isinstance(goal, PoseGoal):
            self._guide.reset()
        if self._goal_motion is not None and not isinstance(goal, PoseGoal):
            self._goal_motion.reset()
        match goal:
            case PoseGoal():
                motion = self._to_pose(state, goal, linearisation, bounds, velocities)
            case PostureGoal():
                motion = self._to_posture(state, goal, bounds)
            case BaseGoal():
                motion = self._to_base_pose(state, goal)
            case None:
                motion = _Motion(np.zeros(model.n))
        # Velocities of the base alone and of a robot that stops are not bounded yet; those from a
        # QP are.
        desired = np.zeros(model.n) if motion.velocities is None else motion.velocities
        bounded = np.minimum(np.maximum(desired, bounds[0]), bounds[1])
        return model.command(bounded), StepReport(
            arrived=motion.arrived,
            position_error=motion.position_error,
            orientation_error=motion.orientation_error,
            manipulability=linearisation.manipulability,
            heading_error=linearisation.heading_error,
            slack=motion.slack,
            solved=motion.velocities is not None,
            bTe=linearisation.bTe,
            base_time=motion.base_time,
            posture_error=motion.posture_error,
        )

    def _to_pose(
        self,
        state: KinematicState,
        goal: PoseGoal,
        linearisation: Linearisation,
        bounds: tuple[Array, Array],
        last: Array,
    ) -> _Motion:
        """Base and arm together to an end-effector pose."""
        model, settings, bTe = self.model, self.settings, linearisation.bTe
        if self._goal_motion is not None:
            goal = self._goal_motion(goal)
        bTw = state.wTb.inverse()
        error = pose_error(bTe, bTw * goal.wTe)
        twist = desired_twist(settings.servo, goal, bTw, bTe, error)
        bias, base_time, posture_error = None, 0.0, 0.0
        if self._guide is not None:
            bias = self._guide.bias(goal, error, Pose2D.of(state.wTb), state.q)
            base_time, posture_error = self._guide.left
        norm = error_norm(settings, bTe, error)
        qp = build_qp(model, settings, linearisation, twist, norm, bounds, last, bias)
        velocities = self._solve(qp, state.q)
        achieved = np.zeros(6) if velocities is None else linearisation.J @ velocities
        slack = twist - achieved
        return _Motion(
            velocities,
            error.position,
            error.orientation,
            arrived=error.position <= goal.position_tolerance
            and error.orientation <= goal.orientation_tolerance,
            slack=sqrt(float(slack @ slack)),
            base_time=base_time,
            posture_error=posture_error,
        )

    def _to_posture(
        self, state: KinematicState, goal: PostureGoal, bounds: tuple[Array, Array]
    ) -> _Motion:
        """The arm to joint positions, all joints arriving together; the base comes to rest."""
        model, servo, limits = self.model, self.settings.servo, self.model.limits
        error = goal.q - state.q
        max_error = float(np.abs(error).max())
        deceleration = limits.qdd.min() * servo.joint_deceleration
        speeds = [
            approach_speed(abs(e), servo.gain, deceleration, qd)
            for e, qd in zip(error, limits.qd, strict=True)
        ]
        duration = max(abs(e) / v if v > 0.0 else 0.0 for e, v in zip(error, speeds, strict=True))
        qd = error / duration if duration > 0.0 else np.zeros_like(error)
        desired = np.concatenate([np.zeros(model.n_base), qd])
        velocities = self._solve(QP(np.eye(model.n), -desired, *bounds), state.q)
        arrived = max_error <= goal.tolerance
        return _Motion(velocities, 0.0, max_error, arrived=arrived, posture_error=max_error)

    def _to_base_pose(self, state: KinematicState, goal: BaseGoal) -> _Motion:
        """The base to a pose; the arm comes to rest."""
        bTg = state.wTb.inverse() * goal.wTb
        error, target, drive = pose_error(SE3.Identity(), bTg), Pose2D.of(bTg), self.settings.drive
        base = drive_to(self.model, self.settings, target, reverse=goal.reverse)
        return _Motion(
            np.concatenate([base, np.zeros(len(state.q))]),
            error.position,
            error.orientation,
            arrived=error.position <= goal.position_tolerance
            and error.orientation <= goal.heading_tolerance,
            base_time=time_to_drive(self.model, drive, target, goal.reverse),
        )

    def _solve(self, qp: QP, q: Array) -> Array | None:
        """The minimiser that keeps parts of the robot apart that are near each other."""
        contact = self.settings.contact
        pairs = self._collision.near(q, contact.influence_distance) if contact is not None else []
        if contact is None or not pairs:
            return self._solver.solve(qp)
        rows = np.zeros((len(pairs), self.model.n))
        rows[:, self.model.n_base :] = [pair.row for pair in pairs]
        limits = np.array([_approach_limit(contact, pair.distance) for pair in pairs])
        return self._soft_solver.solve_soft(qp, rows, -limits, contact.weight)


def _approach_limit(contact: ContactSettings, distance: float) -> float:
    """How fast parts at a distance may approach [m/s]; negative: how fast they must part."""
    room = distance - contact.stop_distance
    if room < 0.0:
        return contact.gain * room
    return approach_speed(room, contact.gain, contact.deceleration, inf)
