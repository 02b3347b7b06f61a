"""The holistic controller: one control step, from state and goal to velocities of base and arm."""

from collections.abc import Sequence
from math import hypot

import numpy as np

from config.poses import MapPose
from controller.collision.collision_model import CollisionModels
from controller.collision.distance_constraints import NOTHING_NEAR, CollisionAvoidance
from controller.collision.moving_obstacles import waits_for
from controller.collision.self_collision import SelfCollision
from controller.command import (
    Array,
    BaseGoal,
    Command,
    KinematicState,
    MotionGoal,
    PoseGoal,
    PostureGoal,
)
from controller.guidance import Guidance
from controller.limits import OTHER_COST, SLACK_COSTS, Constraints, Limit
from controller.model import Lag, RobotModel
from controller.qp_solver import QP, Rows, Solver, joined, nearest_to
from controller.servo import Servo
from controller.settings import ControllerSettings
from controller.situation import Linearisation, Situation, linearise
from controller.step_report import StepReport
from controller.surroundings import OPEN_FLOOR, Surroundings
from controller.tasks import Task, base_task, pose_task, posture_task, rest_task
from controller.terms import STANDARD_TERMS, Aim, Term, qp_of
from controller.validation import check_goal, check_state
from controller.velocity_bounds import VelocityBounds

_MAX_SLACK = 0.1
"""Missing twist from which on base or arm are at their limits, and the arm does not compensate for
the lag of the base [m/s and rad/s]."""
_SAME, _ROUNDING = 1e-8, 1e-5  # absolute and relative, up to which velocities are the same
_MIN_SURPLUS = 0.001  # smaller velocities of the lagging base are not compensated [m/s and rad/s]


def standard_limits(model: RobotModel, settings: ControllerSettings) -> tuple[Limit, ...]:
    """Velocities, accelerations and joint positions; distances, where the settings have them."""
    bounds = VelocityBounds(model, settings)
    if settings.collision is None:
        return (bounds,)
    return bounds, CollisionAvoidance(model, settings.collision, settings.period)


class HolisticController:
    """Turns a motion goal into velocities of base and arm, one period at a time.

    Every command keeps the limits: they are constraints of the QP, and nothing is scaled after it.
    """

    def __init__(
        self,
        model: RobotModel,
        settings: ControllerSettings | None = None,
        *,
        terms: Sequence[Term] = STANDARD_TERMS,
        limits: Sequence[Limit] | None = None,
    ) -> None:
        """`terms` are the cost of a pose goal; `limits`, in this order, hold for every goal.

        Without limits they are the `standard_limits`.
        """
        import scipy.sparse.csgraph  # imported here: only what moves a robot needs it
        import scipy.spatial  # noqa: F401

        self.model = model
        self.settings = settings = settings or ControllerSettings()
        self._widest = tuple(model.velocity_limits)
        self._terms = tuple(terms)
        self._limits = standard_limits(model, settings) if limits is None else tuple(limits)
        avoids = (one for one in self._limits if isinstance(one, CollisionAvoidance))
        self._avoidance = next(avoids, None)
        self._guidance: Guidance | None = None
        if settings.guidance is not None:
            models = self._avoidance.models if self._avoidance else CollisionModels(model)
            self._guidance = Guidance(model, settings, SelfCollision(model), models)
        self._lag = Lag(model, settings.period)
        self._servo = Servo(settings, model.description.arm.lag)
        self._solver = Solver(SLACK_COSTS if limits is None else np.append(SLACK_COSTS, OTHER_COST))
        self._compensated: tuple[Array, Array] | None = None
        """(n,) velocities of the last period in which the arm compensates for the lag of the base,
        and the same without that."""
        self._waits_for = ""
        self._linearised: Linearisation | None = None
        self._periods = 0
        self._checked: MotionGoal[MapPose] | None = None
        """The last goal that was checked."""

    def prepare(self, surroundings: Surroundings) -> None:
        """Compute in advance what the first step in these surroundings needs: some milliseconds."""
        if self._avoidance is not None:
            self._avoidance.prepare(surroundings)
        if self._guidance is not None:
            self._guidance.prepare(surroundings)

    def step(
        self,
        state: KinematicState,
        goal: MotionGoal[MapPose] | None,
        last: Command,
        surroundings: Surroundings = OPEN_FLOOR,
    ) -> tuple[Command, StepReport]:
        """The command for the next period, and the report of this one.

        Args:
            state: of base and arm.
            goal: where to move; None comes smoothly to rest.
            last: the command that the robot applied in the previous period.
            surroundings: the obstacles.

        Raises:
            GoalError: a number in the state, the goal or the last command is not finite, or a
                pose has no rotation matrix.
        """
        now = self._observe(state, goal, last, surroundings)
        task = self._task(now)
        constraints = self._constraints(now)
        qp, rows = self._qp(now, task, constraints), constraints.rows
        velocities = self._solver.solve(qp, rows)
        velocities, slack = self._compensate_base_lag(now, task, constraints, velocities)
        velocities = self._give_way(now, task, qp, rows, velocities)
        report = self._report(now, task, slack, solved=velocities is not None)
        if velocities is None:
            velocities = np.minimum(np.maximum(0.0, qp.lower), qp.upper)
        return self.model.command(velocities), report

    def _observe(
        self,
        state: KinematicState,
        goal: MotionGoal[MapPose] | None,
        last: Command,
        surroundings: Surroundings,
    ) -> Situation:
        """Stage 1: check the inputs; kinematics of this period."""
        base, applied = check_state(state, last), self.model.velocities(last)
        if goal is not self._checked:
            check_goal(goal, len(state.q))
            self._checked = goal
        self._lag.update(applied)
        model, settings = self.model, self.settings
        before = self._linearised if self._periods % settings.slow_periods else None
        kinematics = self._linearised = linearise(model, settings, state.q, before)
        self._periods += 1
        return Situation(
            model, settings, state, base, goal, applied, kinematics, surroundings, self._lag
        )

    def _task(self, now: Situation) -> Task:
        """Stage 2: what the goal asks for."""
        goal, guidance = now.goal, self._guidance
        if isinstance(goal, PoseGoal):
            if guidance is not None:
                guidance.waits = bool(self._waits_for)
            return pose_task(now, goal, self._servo, guidance, self._uncompensated(now.applied))
        if guidance is not None:
            guidance.reset(keeps_bearing=not isinstance(goal, PostureGoal))
        self._servo.reset()
        match goal:
            case PostureGoal():
                return posture_task(now, goal)
            case BaseGoal():
                return base_task(now, goal, guidance)
            case None:
                return rest_task(now)

    def _uncompensated(self, applied: Array) -> Array:
        """Velocities (n,) of the last period, without compensation of the base's lag."""
        if self._compensated is not None:
            (told, without), n_base = self._compensated, self.model.n_base
            missing = np.abs(told - applied)[n_base:]
            if (missing <= _SAME + _ROUNDING * np.abs(applied)[n_base:]).all():  # the robot got it
                return applied - (told - without)
        return applied

    def _constraints(self, now: Situation) -> Constraints:
        """Stage 3: bounds and rows of the QP."""
        constraints = Constraints(*self._widest)
        for limit in self._limits:
            limit(constraints, now)
        return constraints

    def _qp(self, now: Situation, task: Task, constraints: Constraints) -> QP:
        """Stage 4: the QP without its rows."""
        if task.velocities is not None:
            return nearest_to(task.velocities, constraints.lower, constraints.upper)
        assert task.aim is not None
        return qp_of(self._terms, now, task.aim, constraints.lower, constraints.upper)

    def _compensate_base_lag(
        self, now: Situation, task: Task, constraints: Constraints, velocities: Array | None
    ) -> tuple[Array | None, float]:
        """Stage 5: let the arm compensate for the lag of the base; also the norm of the slack."""
        self._compensated = None
        aim, n_base, J = task.aim, self.model.n_base, now.kinematics.J
        if velocities is None or aim is None:
            return velocities, 0.0
        slack = hypot(*(aim.twist - np.dot(J, velocities)).tolist())
        if slack >= _MAX_SLACK or not aim.compensates:
            return velocities, slack
        base = velocities[:n_base]
        surplus = aim.compensates * now.lag.surplus(base)
        if np.abs(surplus).max() < _MIN_SURPLUS:
            return velocities, slack
        late = Aim(aim.goal, aim.twist - J[:, :n_base] @ surplus, aim.error, now.applied)
        lower, upper = (np.concatenate([base, one[n_base:]]) for one in constraints.bounds)
        qp = qp_of(self._terms, now, late, lower, upper)
        compensated = self._solver.solve(qp, constraints.rows)
        if compensated is None:
            return velocities, slack
        self._compensated = compensated, velocities
        return compensated, slack

    def _give_way(
        self, now: Situation, task: Task, qp: QP, rows: Rows | None, velocities: Array | None
    ) -> Array | None:
        """Stage 6: give way to moving obstacles, where the velocities would meet one."""
        self._waits_for, moving = "", now.surroundings.moving
        if self._avoidance is None or now.goal is None or not moving or velocities is None:
            return velocities
        floor = None if self._guidance is None else self._guidance.floor
        led, bounds = task.base_velocity, (qp.lower, qp.upper)
        ahead = self._avoidance.give_way(now, velocities, led, floor, bounds)
        rows = joined(ahead, rows)
        if ahead is not None:
            self._compensated = None  # that command is not sent
            velocities = self._solver.solve(qp, rows)
        self._waits_for = waits_for(now.base, moving, rows, velocities)
        return velocities

    def _report(self, now: Situation, task: Task, slack: float, *, solved: bool) -> StepReport:
        near = NOTHING_NEAR if self._avoidance is None else self._avoidance.nearest
        bTe, _, manipulability, _, heading_error = now.kinematics
        return StepReport(
            task.arrived,
            task.position_error,
            task.orientation_error,
            manipulability,
            heading_error,
            bTe,
            slack,
            solved,
            task.base_time,
            task.posture_error,
            task.unreachable,
            task.stance,
            task.blend,
            task.detour,
            *near,
            None if self._guidance is None else self._guidance.way,
            self._waits_for,
        )
