"""One step of control: from the state of the robot and its goal to velocities."""

from __future__ import annotations

from math import sqrt

import numpy as np
from pinocchio import SE3

from controller.base_lag import BaseLag
from controller.collision import (
    SLACK_COSTS,
    CollisionAvoidance,
    CollisionModels,
    NearestPair,
    SelfCollision,
    waits_for,
)
from controller.command import (
    Array,
    BaseGoal,
    Command,
    KinematicState,
    MotionGoal,
    PoseGoal,
    PostureGoal,
)
from controller.floor import Pose2D, drive_along, plain_lead
from controller.guidance import Guidance
from controller.holistic_qp import Linearisation, build_qp, linearise
from controller.model import RobotModel
from controller.qp_solver import QP, Rows, Solver, joined
from controller.report import StepReport
from controller.servo import Servo, error_norm, pose_error
from controller.settings import ControllerSettings
from controller.surroundings import OPEN_FLOOR, Obstacle, Surroundings
from controller.tasks import GoalQP, qp_towards, to_posture, with_base
from controller.validation import check_inputs
from controller.velocity_bounds import VelocityBounds

_SLOWING = 0.9
"""Share of its velocities that a robot keeps in a period in which it does not know where to go."""
_NEAR = 0.1
"""Nearer to a goal that is reached straight the arm makes up for the lag of the base, and less and
less up to twice this [m]."""
_FOLLOWS = 0.1
"""Where so much is missing to the twist, base or arm are at an end, and the arm makes up for
nothing [m/s and rad/s]."""
_NO_SURPLUS = 0.001
"""What the lag of the base changes less than this is not made up for [m/s and rad/s]."""
_LED = 0.5
"""Share of the guidance from which on the base goes where it is led."""


class HolisticController:
    """Turns a goal into velocities of base and arm, one period at a time.

    Every returned command keeps the velocity, acceleration and joint position limits by
    construction: they are the bounds of the QP, and nothing is scaled after it.

    Args:
        model: the robot.
        settings: gains, weights and distances.
    """

    def __init__(self, model: RobotModel, settings: ControllerSettings | None = None) -> None:
        import scipy.sparse.csgraph  # what only reads tasks does without; a tick must not wait
        import scipy.spatial  # noqa: F401

        self.model = model
        self.settings = settings or ControllerSettings()
        self._bounds = VelocityBounds(model, self.settings)
        self._solver = Solver(SLACK_COSTS)
        collision = self.settings.collision
        models = CollisionModels(model)
        self._avoidance = (
            None
            if collision is None
            else CollisionAvoidance(model, self.settings, collision, models)
        )
        guided = self.settings.guidance is not None
        self._guide = (
            Guidance(model, self.settings, SelfCollision(model), models) if guided else None
        )
        self._servo = Servo(self.settings)
        self._base_lag = BaseLag(model, self.settings.period)
        self._made_up = np.zeros(model.n)
        """(n,) what the arm did in the last period to make up for the lag of the base."""
        self._waits_for = ""

    def prepare(self, surroundings: Surroundings) -> None:
        """Compute now what the first step in surroundings needs; else it does so itself.

        Nothing else changes. It takes some milliseconds, and more where more stands around.
        """
        if self._avoidance is not None:
            self._avoidance.prepare(surroundings)
        if self._guide is not None:
            self._guide.prepare(surroundings)

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
        here = Pose2D.of(state.wTb)
        model, settings = self.model, self.settings
        applied = model.velocities(last)
        bounds = self._bounds(state.q, applied)
        self._base_lag.follow(applied[: model.n_base])
        linearisation = linearise(model, settings, state.q)
        if self._guide is not None and not isinstance(goal, PoseGoal):
            self._guide.reset(keeps_bearing=not isinstance(goal, PostureGoal))
        if not isinstance(goal, PoseGoal):
            self._servo.reset()
        match goal:
            case PoseGoal():
                motion = self._to_pose(
                    state, here, goal, linearisation, bounds, applied, surroundings
                )
            case PostureGoal():
                motion = to_posture(model, settings, state, goal, bounds)
            case BaseGoal():
                motion = self._to_base_pose(state, here, goal, bounds, surroundings)
            case None:
                motion = GoalQP(qp_towards(np.zeros(model.n), bounds))
        rows, near, self._waits_for = None, NearestPair(), ""
        if self._avoidance is not None:
            self._avoidance.follow(applied)
            rows, near = self._avoidance.rows(state, here, goal, bounds, surroundings)
        velocities = self._solver.solve(motion.qp, rows)
        slack, self._made_up = 0.0, np.zeros(model.n)
        if velocities is not None and motion.twist is not None:
            missing = motion.twist - linearisation.J @ velocities
            slack = sqrt(missing @ missing)
            if slack < _FOLLOWS:
                asked, velocities = velocities, self._make_up(motion, rows, velocities)
                self._made_up = velocities - asked
        if goal is not None and surroundings.moving and velocities is not None:
            moving = surroundings.moving
            velocities = self._give_way(here, state.q, motion, rows, velocities, moving)
        solved = velocities is not None
        if velocities is None:
            velocities = np.minimum(np.maximum(0.0, bounds[0]), bounds[1])
        return model.command(velocities), StepReport(
            arrived=motion.arrived,
            position_error=motion.position_error,
            orientation_error=motion.orientation_error,
            manipulability=linearisation.manipulability,
            heading_error=linearisation.heading_error,
            slack=slack,
            solved=solved,
            bTe=linearisation.bTe,
            base_time=motion.base_time,
            posture_error=motion.posture_error,
            unreachable=motion.unreachable,
            stance=motion.stance,
            blend=motion.blend,
            detour=motion.detour,
            clearance=near.clearance,
            nearest=near.name,
            nearest_points=near.points,
            way=None if self._guide is None else self._guide.way,
            near_pairs=near.pairs,
            waits_for=self._waits_for,
        )

    def _make_up(self, motion: GoalQP, rows: Rows | None, velocities: Array) -> Array:
        """Velocities (n,) with which the arm makes up for the lag of the base."""
        alone = motion.arm_alone(velocities[: self.model.n_base])
        made_up = None if alone is None else self._solver.solve(alone, rows)
        return velocities if made_up is None else made_up

    def _give_way(
        self,
        here: Pose2D,
        q: Array,
        motion: GoalQP,
        rows: Rows | None,
        wanted: Array,
        moving: tuple[Obstacle, ...],
    ) -> Array | None:
        """The velocities (n,) that give way to what moves; `wanted` where there is no need."""
        if self._avoidance is None:
            return wanted
        floor = None if self._guide is None else self._guide.floor
        bounds, led = (motion.qp.lower, motion.qp.upper), motion.base_velocity
        ahead = self._avoidance.give_way(here, q, wanted, led, moving, floor, bounds)
        rows = joined(ahead, rows)
        velocities = wanted if ahead is None else self._solver.solve(motion.qp, rows)
        self._waits_for = waits_for(here, moving, rows, velocities)
        return velocities

    def _to_pose(
        self,
        state: KinematicState,
        here: Pose2D,
        goal: PoseGoal,
        linearisation: Linearisation,
        bounds: tuple[Array, Array],
        last: Array,
        surroundings: Surroundings,
    ) -> GoalQP:
        """Base and arm together to an end-effector pose."""
        model, settings, bTe = self.model, self.settings, linearisation.bTe
        goal = self._servo.with_motion(goal)
        bTw = state.wTb.inverse()
        error = pose_error(bTe, bTw * goal.wTe)
        twist = self._servo(goal, bTw, bTe, error)
        bias, base_time, posture_error, bearing = None, 0.0, 0.0, 0.0
        if (guide := self._guide) is not None:
            guide.waits = bool(self._waits_for)
            bias = guide.bias(goal, error, here, state.q, surroundings)
            (base_time, posture_error), bearing = guide.left, guide.bearing
            if goal.next_goal is None:
                guide.onward.reset()
            elif bias is None:
                m, lag = linearisation.manipulability, self._base_lag
                bias = guide.onward.bias(goal.next_goal, error.position, m, lag, here, state.q)
        norm = error_norm(settings, bTe, error)
        steady = last - self._made_up  # what makes up for the lag is not to last
        qp = build_qp(model, settings, linearisation, twist, norm, bounds, steady, bias, bearing)

        near = min(1.0, 2.0 - error.position / _NEAR)
        goes_straight = guide is not None and goal.straight and bias is None and near > 0.0
        if guide is not None and guide.rests:
            qp, goes_straight = qp_towards(_SLOWING * last, bounds), False

        def arm_alone(base: Array) -> QP | None:
            surplus = near * self._base_lag.surplus(base)
            if not goes_straight or np.abs(surplus).max() < _NO_SURPLUS:
                return None
            late = twist - linearisation.J[:, : model.n_base] @ surplus
            fixed = with_base(bounds, base)
            return build_qp(model, settings, linearisation, late, norm, fixed, last)

        return GoalQP(
            qp,
            error.position,
            error.orientation,
            arrived=error.position <= goal.position_tolerance
            and error.orientation <= goal.orientation_tolerance,
            twist=twist,
            base_time=base_time,
            posture_error=posture_error,
            unreachable="" if guide is None else guide.unreachable,
            stance=None if guide is None else guide.base,
            blend=0.0 if bias is None else bias.blend,
            detour=guide is not None and guide.detour,
            base_velocity=None if bias is None or bias.blend < _LED else bias.base_velocity,
            arm_alone=arm_alone,
        )

    def _to_base_pose(
        self,
        state: KinematicState,
        here: Pose2D,
        goal: BaseGoal,
        bounds: tuple[Array, Array],
        surroundings: Surroundings,
    ) -> GoalQP:
        """The base to a pose; the arm comes to rest."""
        error = pose_error(SE3.Identity(), state.wTb.inverse() * goal.wTb)
        there = Pose2D.of(goal.wTb)
        if self._guide is None:
            lead = plain_lead(self.model, self.settings, here, there, goal.reverse)
        else:
            lead = self._guide.lead_base(goal, here, surroundings)
        base = drive_along(self.model, self.settings, lead, goal.speed)
        return GoalQP(
            qp_towards(np.concatenate([base, np.zeros(len(state.q))]), bounds),
            error.position,
            error.orientation,
            arrived=error.position <= goal.position_tolerance
            and error.orientation <= goal.heading_tolerance,
            base_time=lead.time_left,
            unreachable=lead.unreachable,
            base_velocity=base,
        )
