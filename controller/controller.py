"""The holistic controller: one control step, from state and goal to velocities of base and arm."""

from math import hypot

import numpy as np

from controller.collision.collision_model import CollisionModels
from controller.collision.distance_constraints import (
    NOTHING_NEAR,
    SLACK_COSTS,
    CollisionAvoidance,
    NearestPair,
)
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
from controller.holistic_qp import Linearisation, linearise
from controller.model import Lag, RobotModel
from controller.qp_solver import Rows, Solver, joined
from controller.report import StepReport
from controller.settings import ControllerSettings
from controller.surroundings import OPEN_FLOOR, Surroundings
from controller.tasks import PoseTask, Task, Tick, base_task, posture_task, rest_task
from controller.validation import check_goal, check_state
from controller.velocity_bounds import VelocityBounds

_MAX_SLACK = 0.1
"""Missing twist from which on base or arm are at their limits, and the arm does not compensate for
the lag of the base [m/s and rad/s]."""


_UNCERTAIN, _LOST = 0.06, 0.08
"""Uncertainty from which on the base is slower, and at which it has half its speed [m]."""


def _caution(uncertainty: float) -> float:
    """The share of its speed limits that a base may use that knows its place only so well [m]."""
    return 1.0 - 0.5 * min(max((uncertainty - _UNCERTAIN) / (_LOST - _UNCERTAIN), 0.0), 1.0)


class HolisticController:
    """Turns a motion goal into velocities of base and arm, one period at a time.

    Every command keeps the velocity, acceleration and joint position limits: they are bounds of the
    QP, and nothing is scaled after it.
    """

    def __init__(self, model: RobotModel, settings: ControllerSettings | None = None) -> None:
        import scipy.sparse.csgraph  # imported here: only what moves a robot needs it
        import scipy.spatial  # noqa: F401

        self.model = model
        self.settings = settings = settings or ControllerSettings()
        models = CollisionModels(model)
        self._bounds = VelocityBounds(model, settings)
        self._lag = Lag(model, settings.period)
        self._guidance: Guidance | None = None
        if settings.guidance is not None:
            self._guidance = Guidance(model, settings, SelfCollision(model), models)
        self._pose_task = PoseTask(model, settings, self._guidance, self._lag)
        self._avoidance: CollisionAvoidance | None = None
        if settings.collision is not None:
            self._avoidance = CollisionAvoidance(model, settings.collision, models, self._lag)
        self._solver = Solver(SLACK_COSTS)
        self._compensated: tuple[Array, Array] | None = None
        """(n,) velocities of the last period in which the arm compensates for the lag of the base,
        and the same without that."""
        self._waits_for = ""
        self._linearised: Linearisation | None = None
        self._periods = 0
        self._checked: MotionGoal | None = None
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
        goal: MotionGoal | None,
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
        tick = self._observe(state, goal, last, surroundings)
        task = self._task(tick)
        rows, nearest = self._distance_constraints(tick)
        velocities = self._solver.solve(task.qp, rows)
        velocities, slack = self._compensate_base_lag(tick, task, rows, velocities)
        velocities = self._give_way(tick, task, rows, velocities)
        report = self._report(tick, task, nearest, slack, solved=velocities is not None)
        if velocities is None:
            velocities = np.minimum(np.maximum(0.0, tick.bounds[0]), tick.bounds[1])
        return self.model.command(velocities), report

    def _observe(
        self,
        state: KinematicState,
        goal: MotionGoal | None,
        last: Command,
        surroundings: Surroundings,
    ) -> Tick:
        """Stage 1: check the inputs; velocity bounds and kinematics of this period."""
        base, applied = check_state(state, last), self.model.velocities(last)
        if goal is not self._checked:
            check_goal(goal, len(state.q))
            self._checked = goal
        bounds = self._bounds(state.q, applied, _caution(surroundings.uncertainty))
        self._lag.update(applied)
        before = self._linearised if self._periods % self.settings.slow_periods else None
        kinematics = self._linearised = linearise(self.model, self.settings, state.q, before)
        self._periods += 1
        return Tick(state, base, goal, applied, bounds, kinematics, surroundings)

    def _task(self, tick: Tick) -> Task:
        """Stage 2: the QP of the goal."""
        goal = tick.goal
        if isinstance(goal, PoseGoal):
            if self._guidance is not None:
                self._guidance.waits = bool(self._waits_for)
            steady, arm = tick.applied, slice(self.model.n_base, None)
            if self._compensated is not None:
                told, without = self._compensated
                if np.allclose(told[arm], tick.applied[arm]):  # the robot got it
                    steady = tick.applied - (told - without)
            return self._pose_task(tick, goal, steady)
        self._pose_task.reset(goal)
        match goal:
            case PostureGoal():
                return posture_task(self.model, self.settings, tick, goal)
            case BaseGoal():
                return base_task(self.model, self.settings, self._guidance, tick, goal)
            case None:
                return rest_task(tick)

    def _distance_constraints(self, tick: Tick) -> tuple[Rows | None, NearestPair]:
        """Stage 3: rows of the QP that keep the robot off obstacles and itself."""
        if self._avoidance is None:
            return None, NOTHING_NEAR
        return self._avoidance.rows(
            tick.state, tick.base, tick.goal, tick.bounds, tick.surroundings
        )

    def _compensate_base_lag(
        self, tick: Tick, task: Task, rows: Rows | None, velocities: Array | None
    ) -> tuple[Array | None, float]:
        """Stage 4: let the arm compensate for the lag of the base; also the norm of the slack."""
        self._compensated = None
        if velocities is None or task.twist is None:
            return velocities, 0.0
        missing = task.twist - tick.kinematics.J @ velocities
        slack = hypot(*missing.tolist())
        if slack >= _MAX_SLACK:
            return velocities, slack
        qp = task.lag_compensation(velocities[: self.model.n_base])
        compensated = None if qp is None else self._solver.solve(qp, rows)
        if compensated is None:
            return velocities, slack
        self._compensated = compensated, velocities
        return compensated, slack

    def _give_way(
        self, tick: Tick, task: Task, rows: Rows | None, velocities: Array | None
    ) -> Array | None:
        """Stage 5: give way to moving obstacles, where the velocities would meet one."""
        self._waits_for, moving = "", tick.surroundings.moving
        if self._avoidance is None or tick.goal is None or not moving or velocities is None:
            return velocities
        floor = None if self._guidance is None else self._guidance.floor
        ahead = self._avoidance.give_way(
            tick.base, tick.state.q, velocities, task.base_velocity, moving, floor, tick.bounds
        )
        rows = joined(ahead, rows)
        if ahead is not None:
            self._compensated = None  # that command is not sent
            velocities = self._solver.solve(task.qp, rows)
        self._waits_for = waits_for(tick.base, moving, rows, velocities)
        return velocities

    def _report(
        self, tick: Tick, task: Task, nearest: NearestPair, slack: float, *, solved: bool
    ) -> StepReport:
        return StepReport(
            manipulability=tick.kinematics.manipulability,
            heading_error=tick.kinematics.heading_error,
            bTe=tick.kinematics.bTe,
            **task.measured,
            slack=slack,
            solved=solved,
            clearance=nearest.clearance,
            nearest=nearest.name,
            nearest_points=nearest.points,
            way=None if self._guidance is None else self._guidance.way,
            waits_for=self._waits_for,
        )
