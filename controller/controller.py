"""The holistic controller: one control step, from state and goal to velocities of base and arm."""

from collections.abc import Sequence
from math import hypot

import numpy as np
from pinocchio import SE3

from config.planar import ORIGIN
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
from controller.terms import STANDARD_TERMS, Aim, Cost, Term
from controller.validation import add_all, check_goal, check_state
from controller.velocity_bounds import VelocityBounds

_AT_LIMITS = 0.1
"""Slack of the twist from which on base or arm are at their limits, and the arm does not compensate
for the lag of the base [m/s and rad/s]."""
_SAME, _ROUNDING = 1e-8, 1e-5  # absolute and relative, up to which velocities are the same
_MIN_SURPLUS = 0.001  # smaller velocities of the lagging base are not compensated [m/s and rad/s]


class HolisticController:
    """Turns a motion goal into velocities of base and arm, one period at a time.

    Every command keeps the bounds of velocities and accelerations: they are constraints of the QP,
    and nothing is scaled after it. Rows, as of distances, are kept where bounds and other rows
    leave a way to; else the QP misses them by as little as their costs say. `_brake` answers a QP
    that is not solved.
    """

    def __init__(
        self,
        model: RobotModel,
        settings: ControllerSettings | None = None,
        *,
        terms: Sequence[Term] = (),
        limits: Sequence[Limit] = (),
        standard_terms: Sequence[Term] = STANDARD_TERMS,
        standard_limits: bool = True,
    ) -> None:
        """`terms`, of pose goals, and `limits`, of all goals, are added to the standard ones.

        `standard_terms` may be fewer or others. Without `standard_limits` only the velocity limits
        remain of them. What is added is called once here, with the ready posture: a GoalError says
        what is not finite or has a wrong size.
        """
        import scipy.sparse.csgraph  # imported here: only what moves a robot needs it
        import scipy.spatial  # noqa: F401

        self.model = model
        self.settings = settings = settings or ControllerSettings()
        self._widest = tuple(model.velocity_limits)
        self._terms, self._own_limits = (*standard_terms, *terms), tuple(limits)
        if any(term in standard_terms for term in terms):
            raise ValueError("terms are added to the standard ones: name only what is yours")
        self._checks_terms = any(term not in STANDARD_TERMS for term in self._terms)
        self._limits: list[Limit] = [VelocityBounds(model, settings)] if standard_limits else []
        self._avoidance: CollisionAvoidance | None = None
        if standard_limits and settings.collision:
            self._avoidance = CollisionAvoidance(model, settings.period)
            self._limits.append(self._avoidance)
        self._limits += limits
        self._guidance: Guidance | None = None
        if settings.guidance:
            models = self._avoidance.models if self._avoidance else CollisionModels(model)
            self._guidance = Guidance(model, settings, SelfCollision(model), models)
        self._lag = Lag(model, settings.period)
        self._servo = Servo(settings, model.description.arm.lag)
        self._solver = Solver(np.append(SLACK_COSTS, OTHER_COST) if limits else SLACK_COSTS)
        self._compensated: tuple[Array, Array, Array] | None = None
        """(n,) velocities of the last period in which the arm compensates for the lag of the base,
        the same without that, and the twist (6,) that the former were asked for."""
        self._waits_for = ""
        self._linearised: Linearisation | None = None
        self._periods = 0
        self._checked: MotionGoal[MapPose] | None = None
        """The last goal that was checked."""
        if limits or self._checks_terms:
            self._try_out()

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
            GoalError: something in the state, the goal or the last command, or what a term or limit
                adds, is of a wrong kind or size or not finite; or a pose has no rotation matrix.
        """
        now = self._observe(state, goal, last, surroundings)
        task = self._task(now)
        constraints = self._constraints(now)
        qp, rows = self._qp(now, task, constraints), constraints.rows
        found = self._solver.solve(qp, rows)
        found = self._compensate_base_lag(now, task, constraints, found)
        found = self._give_way(now, task, qp, rows, found)
        velocities = self._brake(qp) if found is None else found
        report = self._report(now, task, rows, velocities, solved=found is not None)
        return self.model.command(velocities), report

    def _try_out(self) -> None:
        """Call terms and limits that are not from here once, before anything moves."""
        model, settings, q = self.model, self.settings, self.model.description.arm.ready
        state, still = KinematicState(SE3.Identity(), q), np.zeros(model.n)
        goal, kinematics = PoseGoal(target=model.bTe(q)), linearise(model, settings, q)
        now = Situation(
            model, settings, state, ORIGIN, goal, still, kinematics, OPEN_FLOOR, self._lag
        )
        add_all("limit", self._own_limits, Constraints(*self._widest), now)
        self._pose_qp(now, Aim(goal, np.zeros(6), 0.0, still), *self._widest)

    @staticmethod
    def _brake(qp: QP) -> Array:
        """Velocities (n,) nearest to rest within the bounds, for a QP that was not solved.

        They may miss rows: none are known that keep them, and to brake is the safest of the rest.
        """
        return np.minimum(np.maximum(0.0, qp.lower), qp.upper)

    def _observe(
        self,
        state: KinematicState,
        goal: MotionGoal[MapPose] | None,
        last: Command,
        surroundings: Surroundings,
    ) -> Situation:
        """Stage 1: check the inputs; kinematics of this period."""
        base = check_state(state, last, self.model.n_arm)
        applied = self.model.velocities(last)
        if goal is not self._checked:
            check_goal(goal, self.model.n_arm)
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
            (told, without, _), n_base = self._compensated, self.model.n_base
            missing = np.abs(told - applied)[n_base:]
            if (missing <= _SAME + _ROUNDING * np.abs(applied)[n_base:]).all():  # the robot got it
                return applied - (told - without)
        return applied

    def _constraints(self, now: Situation) -> Constraints:
        """Stage 3: bounds and rows of the QP."""
        constraints = Constraints(*self._widest)
        add_all("limit", self._limits, constraints, now)
        return constraints

    def _qp(self, now: Situation, task: Task, constraints: Constraints) -> QP:
        """Stage 4: the QP without its rows."""
        if task.velocities is not None:
            return nearest_to(task.velocities, constraints.lower, constraints.upper)
        assert task.aim is not None
        return self._pose_qp(now, task.aim, *constraints.bounds)

    def _pose_qp(self, now: Situation, aim: Aim, lower: Array, upper: Array) -> QP:
        cost = Cost(self.model, checks=self._checks_terms)
        add_all("term", self._terms, cost, now, aim)
        return cost.qp(lower, upper)

    def _compensate_base_lag(
        self, now: Situation, task: Task, constraints: Constraints, velocities: Array | None
    ) -> Array | None:
        """Stage 5: let the arm compensate for the lag of the base."""
        self._compensated = None
        aim, n_base, J = task.aim, self.model.n_base, now.kinematics.J
        if velocities is None or aim is None or not aim.compensates:
            return velocities
        if _slack(aim.twist, J, velocities) >= _AT_LIMITS:
            return velocities
        base = velocities[:n_base]
        surplus = aim.compensates * now.lag.surplus(base)
        if np.abs(surplus).max() < _MIN_SURPLUS:
            return velocities
        late = Aim(aim.goal, aim.twist - J[:, :n_base] @ surplus, aim.error, now.applied)
        lower, upper = (np.concatenate([base, one[n_base:]]) for one in constraints.bounds)
        qp = self._pose_qp(now, late, lower, upper)
        compensated = self._solver.solve(qp, constraints.rows)
        if compensated is None:
            return velocities
        self._compensated = compensated, velocities, late.twist
        return compensated

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

    def _report(
        self, now: Situation, task: Task, rows: Rows | None, velocities: Array, *, solved: bool
    ) -> StepReport:
        """Stage 7: what is told of these velocities (n,), which are sent."""
        near = NOTHING_NEAR if self._avoidance is None else self._avoidance.nearest
        bTe, J, manipulability, _, heading_error = now.kinematics
        slack = shortfall = 0.0
        if task.aim is not None:
            twist = task.aim.twist if self._compensated is None else self._compensated[2]
            slack = _slack(twist, J, velocities)
        if self._own_limits and rows is not None:
            missed = (rows.least - rows.A @ velocities)[rows.group == len(SLACK_COSTS)]
            shortfall = float(missed.max(initial=0.0))
        return StepReport(
            arrived=task.arrived,
            position_error=task.position_error,
            orientation_error=task.orientation_error,
            manipulability=manipulability,
            heading_error=heading_error,
            bTe=bTe,
            slack=slack,
            solved=solved,
            base_time=task.base_time,
            posture_error=task.posture_error,
            unreachable=task.unreachable,
            stance=task.stance,
            blend=task.blend,
            detour=task.detour,
            clearance=near.clearance,
            nearest=near.name,
            nearest_points=near.points,
            way=None if self._guidance is None else self._guidance.way,
            waits_for=self._waits_for,
            shortfall=shortfall,
        )


def _slack(twist: Array, J: Array, velocities: Array) -> float:
    """Norm of the twist (6,) that velocities (n,) leave [m/s and rad/s]."""
    return hypot(*(twist - np.dot(J, velocities)).tolist())
