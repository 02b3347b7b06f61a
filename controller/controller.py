"""One step of control: where the robot is and where it should be, in; velocities, out."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, sqrt
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from controller.base_drive import drive_to, planar
from controller.bounds import velocity_bounds
from controller.command import (
    Array,
    BaseGoal,
    Command,
    KinematicState,
    MotionGoal,
    PoseGoal,
    PostureGoal,
)
from controller.guidance import Guide
from controller.holistic import Linearisation, assemble, linearise
from controller.model import RobotModel
from controller.qp import QP, ROUGH, Solver
from controller.self_collision import SelfCollision
from controller.servo import approach_speed, desired_twist, norm_of, pose_error
from controller.settings import ControllerSettings
from controller.validation import require_sound


@dataclass(frozen=True, kw_only=True, eq=False)
class StepReport:
    """What one control step saw and did."""

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
    """|δ|: norm of the end-effector twist that was wanted and not given [m/s and rad/s]."""
    solved: bool
    """Whether the quadratic qp was solved; if not, the command brakes."""
    bTe: SE3
    """End effector in the base."""


class _Answer(NamedTuple):
    """What one kind of goal asks for."""

    velocities: Array | None
    position_error: float = np.nan
    orientation_error: float = np.nan
    arrived: bool = False
    slack: float = 0.0


class HolisticController:
    """Turns a goal into velocities of base and arm, one period at a time.

    Every returned command keeps the speed, acceleration and joint position limits by construction:
    they are the bounds of the qp, and nothing is scaled after it.

    Args:
        model: the robot.
        settings: the gains.
    """

    def __init__(self, model: RobotModel, settings: ControllerSettings | None = None) -> None:
        self.model = model
        self.settings = settings or ControllerSettings()
        self._solver = Solver()
        self._soft_solver = Solver(ROUGH)
        self._body = SelfCollision(model)
        self._guide = Guide(model, self.settings, self._body) if self.settings.guidance else None

    def step(
        self, state: KinematicState, goal: MotionGoal | None, last: Command
    ) -> tuple[Command, StepReport]:
        """The command for the next period.

        Args:
            state: where base and arm are.
            goal: where to go; None comes smoothly to rest.
            last: what the robot applied in the previous period.

        Raises:
            GoalError: a number in the state, the goal or the last command is not finite, or a pose
                is none.
        """
        require_sound(state, goal, last)
        model, settings = self.model, self.settings
        velocities = model.velocities(last)
        bounds = velocity_bounds(model, settings, state.q, velocities)
        linearisation = linearise(model, settings, state.q)
        if self._guide is not None and not isinstance(goal, PoseGoal):
            self._guide.forget()
        match goal:
            case PoseGoal():
                answer = self._reach(state, goal, linearisation, bounds, velocities)
            case PostureGoal():
                answer = self._fold(state, goal, bounds)
            case BaseGoal():
                answer = self._drive(state, goal)
            case None:
                answer = _Answer(np.zeros(model.n))
        # A base that drives and a robot that stops have no other bounds to keep; the programmes'
        # answers are inside already.
        wanted = np.zeros(model.n) if answer.velocities is None else answer.velocities
        within = np.minimum(np.maximum(wanted, bounds[0]), bounds[1])
        return model.command(within), StepReport(
            arrived=answer.arrived,
            position_error=answer.position_error,
            orientation_error=answer.orientation_error,
            manipulability=linearisation.manipulability,
            heading_error=linearisation.heading_error,
            slack=answer.slack,
            solved=answer.velocities is not None,
            bTe=linearisation.bTe,
        )

    def _reach(
        self,
        state: KinematicState,
        goal: PoseGoal,
        linearisation: Linearisation,
        bounds: tuple[Array, Array],
        last: Array,
    ) -> _Answer:
        """Base and arm as one towards an end-effector pose."""
        model, settings = self.model, self.settings
        bTw = state.wTb.inverse()
        error = pose_error(linearisation.bTe, bTw * goal.wTe)
        twist = desired_twist(settings, goal, bTw, linearisation.bTe, error)
        bias = None
        if self._guide is not None:
            bias = self._guide.bias(goal, error, planar(state.wTb), state.q)
        distance = norm_of(settings, linearisation.bTe, error)
        qp = assemble(model, settings, linearisation, twist, distance, bounds, last, bias)
        velocities = self._solve(qp, state.q)
        given = np.zeros(6) if velocities is None else linearisation.J @ velocities
        slack = twist - given
        return _Answer(
            velocities,
            error.position,
            error.orientation,
            arrived=error.position <= goal.position_tolerance
            and error.orientation <= goal.orientation_tolerance,
            slack=sqrt(float(slack @ slack)),
        )

    def _solve(self, qp: QP, q: Array) -> Array | None:
        """Solve it, parts of the robot that are near each other kept apart."""
        s = self.settings
        near = self._body.near(q, s.contact_influence) if s.avoid_contact else []
        if not near:
            return self._solver.solve(qp)
        rows = np.zeros((len(near), self.model.n))
        rows[:, self.model.n_base :] = [pair.row for pair in near]
        allowed = [self._allowed_approach(pair.distance - s.contact_stop) for pair in near]
        return self._soft_solver.solve_soft(qp, rows, -np.array(allowed))

    def _allowed_approach(self, room: float) -> float:
        """How fast parts may approach that have so much room left [m/s]; negative is apart."""
        s = self.settings
        if room < 0.0:
            return s.contact_gain * room
        return approach_speed(room, s.contact_gain, s.contact_deceleration, inf)

    def _fold(
        self, state: KinematicState, goal: PostureGoal, bounds: tuple[Array, Array]
    ) -> _Answer:
        """The arm to joint positions, all joints arriving together; the base comes to rest."""
        s, model = self.settings, self.model
        error = goal.q - state.q
        farthest = float(np.abs(error).max())
        slowest = model.limits.qdd.min()
        speeds = [
            approach_speed(abs(e), s.servo_gain, slowest / 2.0, qd)
            for e, qd in zip(error, model.limits.qd, strict=True)
        ]
        duration = max(abs(e) / v if v > 0.0 else 0.0 for e, v in zip(error, speeds, strict=True))
        qd = error / duration if duration > 0.0 else np.zeros_like(error)
        wanted = np.concatenate([np.zeros(model.n_base), qd])
        velocities = self._solve(QP(np.eye(model.n), -wanted, *bounds), state.q)
        return _Answer(velocities, 0.0, farthest, arrived=farthest <= goal.tolerance)

    def _drive(self, state: KinematicState, goal: BaseGoal) -> _Answer:
        """The base to a pose; the arm comes to rest."""
        bTg = state.wTb.inverse() * goal.wTb
        error = pose_error(SE3.Identity(), bTg)
        base = drive_to(self.model, self.settings, planar(bTg), reverse=goal.reverse)
        return _Answer(
            np.concatenate([base, np.zeros(len(state.q))]),
            error.position,
            error.orientation,
            arrived=error.position <= goal.position_tolerance
            and error.orientation <= goal.heading_tolerance,
        )
