"""One step of control: where the robot is and where it should be, in; velocities, out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from controller.base_drive import drive_to
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
from controller.holistic import Situation, Solver, assemble, look
from controller.model import RobotModel
from controller.servo import approach_speed, directed, pose_error
from controller.settings import ControllerSettings


class GoalError(ValueError):
    """A goal or a state that is not finite."""


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
    """Whether the quadratic programme was solved; if not, the command brakes."""
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
    they are the bounds of the programme, and nothing is scaled after it.

    Args:
        model: the robot.
        settings: the gains.
    """

    def __init__(self, model: RobotModel, settings: ControllerSettings | None = None) -> None:
        self.model = model
        self.settings = settings or ControllerSettings()
        self._solver = Solver()

    def step(
        self, state: KinematicState, goal: MotionGoal | None, last: Command
    ) -> tuple[Command, StepReport]:
        """The command for the next period.

        Args:
            state: where base and arm are.
            goal: where to go; None comes smoothly to rest.
            last: what the robot applied in the previous period.

        Raises:
            GoalError: a number in the state, the goal or the last command is not finite.
        """
        _require_finite(state, goal, last)
        model = self.model
        bounds = velocity_bounds(model, self.settings, state.q, model.velocities(last))
        situation = look(model, state.q)
        match goal:
            case PoseGoal():
                answer = self._reach(state, goal, situation, bounds)
            case PostureGoal():
                answer = self._fold(state, goal)
            case BaseGoal():
                answer = self._drive(state, goal)
            case None:
                answer = _Answer(np.zeros(model.n))
        # Where the axes do not depend on each other the projection onto the bounds is the answer of
        # min |x - velocities|²; the holistic programme's answer is inside already.
        wanted = np.zeros(model.n) if answer.velocities is None else answer.velocities
        return model.command(np.clip(wanted, *bounds)), StepReport(
            arrived=answer.arrived,
            position_error=answer.position_error,
            orientation_error=answer.orientation_error,
            manipulability=situation.manipulability,
            heading_error=situation.heading_error,
            slack=answer.slack,
            solved=answer.velocities is not None,
            bTe=situation.bTe,
        )

    def _reach(
        self,
        state: KinematicState,
        goal: PoseGoal,
        situation: Situation,
        bounds: tuple[Array, Array],
    ) -> _Answer:
        """Base and arm as one towards an end-effector pose."""
        s = self.settings
        bTw = state.wTb.inverse()
        error = pose_error(situation.bTe, bTw * goal.wTe)
        twist = np.concatenate(
            [
                directed(
                    error.translation_vector,
                    error.position,
                    approach_speed(error.position, s.servo_gain, s.servo_deceleration, goal.speed),
                )
                + bTw.rotation @ goal.twist[:3],
                directed(
                    error.rotation_vector,
                    error.orientation,
                    approach_speed(
                        error.orientation, s.servo_gain, s.servo_turn_deceleration, goal.turn_rate
                    ),
                )
                + bTw.rotation @ goal.twist[3:],
            ]
        )
        programme = assemble(self.model, s, situation, twist, error.position, bounds)
        velocities = self._solver.solve(programme)
        given = np.zeros(6) if velocities is None else situation.J @ velocities
        return _Answer(
            velocities,
            error.position,
            error.orientation,
            arrived=error.position <= goal.position_tolerance
            and error.orientation <= goal.orientation_tolerance,
            slack=float(np.linalg.norm(twist - given)),
        )

    def _fold(self, state: KinematicState, goal: PostureGoal) -> _Answer:
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
        velocities = np.concatenate([np.zeros(model.n_base), qd])
        return _Answer(velocities, 0.0, farthest, arrived=farthest <= goal.tolerance)

    def _drive(self, state: KinematicState, goal: BaseGoal) -> _Answer:
        """The base to a pose; the arm comes to rest."""
        bTg = state.wTb.inverse() * goal.wTb
        error = pose_error(SE3.Identity(), bTg)
        base = drive_to(self.model, self.settings, bTg)
        return _Answer(
            np.concatenate([base, np.zeros(len(state.q))]),
            error.position,
            error.orientation,
            arrived=error.position <= goal.position_tolerance
            and error.orientation <= goal.heading_tolerance,
        )


def _require_finite(state: KinematicState, goal: MotionGoal | None, last: Command) -> None:
    numbers = {
        "base pose": state.wTb.homogeneous,
        "joint positions": state.q,
        "last base twist": last.base_twist,
        "last joint velocities": last.qd,
    }
    match goal:
        case PoseGoal():
            numbers |= {"goal pose": goal.wTe.homogeneous, "goal twist": goal.twist}
        case PostureGoal():
            numbers["goal posture"] = goal.q
        case BaseGoal():
            numbers["goal base pose"] = goal.wTb.homogeneous
    for name, values in numbers.items():
        if not np.isfinite(values).all():
            raise GoalError(f"the {name} must be finite numbers, got {np.array(values).tolist()}")
