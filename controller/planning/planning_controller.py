"""Base first, then the arm: the usual way that the holistic controller is compared with.

To a pose of the hand the arm folds, the base drives to a place before the goal, and the arm
follows a planned trajectory. Each begins when the one before is over and at rest. A goal that moves
a little meanwhile is not followed: what was planned is carried out, and then planned anew. What
moves by itself counts where it is when a plan is made, and points that a camera has seen do not.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from controller.collision import CollisionModels, SelfCollision
from controller.command import (
    Array,
    BaseGoal,
    Command,
    KinematicState,
    MotionGoal,
    PoseGoal,
    PostureGoal,
)
from controller.controller import HolisticController
from controller.floor import Pose2D
from controller.model import RobotModel
from controller.planning.arm_planner import ArmPlanner
from controller.planning.left import left_to
from controller.planning.settings import PlanningSettings
from controller.planning.trajectory import Trajectory
from controller.report import StepReport
from controller.servo import pose_error
from controller.settings import ControllerSettings
from controller.stance import Stance, StanceFinder, se3_of
from controller.stance_settings import StanceSettings
from controller.surroundings import OPEN_FLOOR, Surroundings
from controller.validation import check_inputs
from controller.velocity_bounds import VelocityBounds

_AT_REST = 1e-3
"""Commands that are slower than this are none [m/s and rad/s]."""
_LAGS = 4.0
"""The robot rests so many of its time constants after its last command."""
_PROGRESS = 0.01
"""What counts as a base that comes nearer [m and s]."""


class _Now(NamedTuple):
    """What a tick is about."""

    state: KinematicState
    last: Command
    surroundings: Surroundings


class _NoWayError(Exception):
    """A goal cannot be reached; the text says why."""


_Way = Generator[Command, None, None]
"""Commands, one a tick, to where something has been done."""


class PlanningController:
    """Turns a goal into velocities as `HolisticController` does, by plans that it then follows.

    Goals for the base alone, and coming to rest, are those of the holistic controller: it is the
    driver of the base.

    Args:
        model: the robot.
        settings: of the control period, and of the base.
        planning: of the plans.

    Raises:
        PlanningError: the library that plans is not installed.
    """

    def __init__(
        self,
        model: RobotModel,
        settings: ControllerSettings | None = None,
        planning: PlanningSettings | None = None,
    ) -> None:
        self.model = model
        self.settings = settings = settings or ControllerSettings()
        self._planning = planning or PlanningSettings()
        stance = StanceSettings() if settings.guidance is None else settings.guidance.stance
        models = CollisionModels(model)
        self._arm = ArmPlanner(model, self._planning, stance, settings.period, models)
        self._finder = StanceFinder(model, stance, SelfCollision(model), models)
        self._driver = HolisticController(model, settings)
        self._bounds = VelocityBounds(model, settings)
        self._forget()

    def _forget(self) -> None:
        self._goal: MotionGoal | None = None
        self._way: Iterator[Command] = iter(())
        self._unreachable = ""
        self._left = 0.0
        self._plans = False
        self._attempts = 0

    def prepare(self, surroundings: Surroundings) -> None:
        """Compute now what the first step in surroundings needs."""
        self._driver.prepare(surroundings)
        self._finder.map(surroundings.fixtures)

    def step(
        self,
        state: KinematicState,
        goal: MotionGoal | None,
        last: Command,
        surroundings: Surroundings = OPEN_FLOOR,
    ) -> tuple[Command, StepReport]:
        """The command for the next period; see `HolisticController.step`.

        Raises:
            GoalError: a number in the state, the goal or the last command is not finite, or a
                pose has no rotation matrix.
        """
        check_inputs(state, goal, last)
        if goal is None or isinstance(goal, BaseGoal):
            self._forget()
            return self._driver.step(state, goal, last, surroundings)
        if self._is_other(goal):
            self._forget()
            self._goal, self._way = goal, self._way_to(goal)
        self._now = _Now(state, last, surroundings)
        command = next(self._way, None)
        if command is None:
            command = self._over(goal)
        return command, self._report(goal)

    def _over(self, goal: PoseGoal | PostureGoal) -> Command:
        """Stay at a goal that is reached; plan once more to one that has moved meanwhile."""
        reached, again = self._report(goal).arrived, self._planning.attempts
        if not reached and not self._unreachable and self._attempts < again:
            self._goal, self._way = goal, self._way_to(goal)
            return next(self._way, self._rest())
        if not reached and not self._unreachable:
            self._unreachable = f"not there after {again} plans"
        self._plans, self._left = False, 0.0
        return self._rest()

    def _is_other(self, goal: PoseGoal | PostureGoal) -> bool:
        """Whether what was planned is not for this goal, nor for one that is nearly there."""
        known, settings = self._goal, self._planning
        if isinstance(goal, PoseGoal) and isinstance(known, PoseGoal):
            error = pose_error(known.wTe, goal.wTe)
            moved = error.position > settings.other_goal or error.orientation > settings.other_turn
            return moved or (bool(self._unreachable) and goal.straight != known.straight)
        if isinstance(goal, PostureGoal) and isinstance(known, PostureGoal):
            return bool(np.abs(goal.q - known.q).max() > goal.tolerance)
        return True

    def _way_to(self, goal: PoseGoal | PostureGoal) -> _Way:
        """All that it takes to get to a goal."""
        self._attempts += 1
        self._left = np.inf
        try:
            yield from self._stop()
            if isinstance(goal, PostureGoal):
                yield from self._posture(goal.q)
            elif (plan := self._plan_to(goal)) is not None:
                yield from self._think()
                yield from self._follow(plan)
            elif goal.straight and goal.hand_may_touch:
                yield from self._think()
                raise _NoWayError("the arm finds no way there from here")
            else:
                yield from self._drive_and_reach(goal)
        except _NoWayError as error:
            self._unreachable = str(error)

    def _plan_to(self, goal: PoseGoal) -> Trajectory | None:
        state, _, surroundings = self._now
        return self._arm.to_pose(state, goal, surroundings)

    def _posture(self, q: Array) -> _Way:
        """The arm to joint positions (7,)."""
        state, _, surroundings = self._now
        plan = self._arm.to_posture(state, q, surroundings)
        yield from self._think()
        if plan is None:
            raise _NoWayError("the arm finds no way to the posture")
        yield from self._follow(plan)

    def _drive_and_reach(self, goal: PoseGoal) -> _Way:
        """Fold the arm, drive to where the goal is in reach, and reach for it."""
        failed: tuple[Stance, ...] = ()
        for _ in range(self._planning.attempts):
            stance = self._stance(goal, failed)
            failed = (*failed, stance)
            ready = self.model.description.arm.ready
            if np.abs(self._now.state.q - ready).max() > self._planning.folded:
                plan = self._arm.to_posture(self._now.state, ready, self._now.surroundings)
                yield from self._think()
                if plan is not None:
                    yield from self._follow(plan)
            there = yield from self._drive(stance, goal)
            yield from self._stop()
            plan = self._plan_to(replace(goal, straight=False)) if there else None
            yield from self._think()
            if plan is not None:
                yield from self._follow(plan)
                return
        raise _NoWayError("no way of base and arm was found")

    def _stance(self, goal: PoseGoal, failed: tuple[Stance, ...]) -> Stance:
        state, _, surroundings = self._now
        self._finder.meet(surroundings)
        if reason := self._finder.obstacle_to(goal):
            raise _NoWayError(reason)
        search = self._finder.search(goal.wTe, Pose2D.of(state.wTb), state.q, failed)
        stance = search.finish()
        if stance is None or (reason := self._finder.why_none(search)):
            raise _NoWayError(reason if stance is not None else "there is no place to stand")
        return stance

    def _drive(self, stance: Stance, goal: PoseGoal) -> Generator[Command, None, bool]:
        """The base to its place, the arm as it is; whether it got there."""
        target = BaseGoal(wTb=se3_of(stance.base_for(goal.wTe)), reverse=stance.reverse)
        best, since = np.inf, 0
        while since * self.settings.period < self._planning.drive_patience:
            state, last, surroundings = self._now
            command, report = self._driver.step(state, target, last, surroundings)
            if report.arrived or report.unreachable:
                return report.arrived
            self._left = report.base_time
            left = report.base_time + report.position_error
            since = 0 if left < best - _PROGRESS else since + 1
            best = min(left, best)
            yield command
        return False

    def _stop(self) -> _Way:
        """Come to rest, within the usual limits."""
        description = self.model.description
        lag = max(description.base.lag, description.arm.lag)
        waits = 0
        while waits * self.settings.period < _LAGS * lag:
            moves = np.abs(self.model.velocities(self._now.last)).max() > _AT_REST
            if not moves and waits == 0:
                return
            waits = 0 if moves else waits + 1
            yield self._rest()

    def _think(self) -> _Way:
        """Stand for as long as planning is charged with."""
        self._plans = True
        for _ in range(round(self._planning.planning_time / self.settings.period)):
            yield self._rest()
        self._plans = False

    def _rest(self) -> Command:
        state, last, surroundings = self._now
        return self._driver.step(state, None, last, surroundings)[0]

    def _follow(self, plan: Trajectory) -> _Way:
        """The joints along a plan, and to its end."""
        settings, period = self._planning, self.settings.period
        late = round(self.model.description.arm.lag / period)
        n_base = self.model.n_base
        patience = round(settings.patience / period)
        for number in range(len(plan.q) + patience):
            state, last, _ = self._now
            self._left = max(0.0, plan.duration - number * period)
            error = plan.q[min(max(number - late, 0), len(plan.q) - 1)] - state.q
            over = number >= len(plan.q)
            if over and np.abs(error).max() < settings.settled:
                return
            qd = settings.gain * error
            if not over:
                qd = qd + plan.qd[number]
            wanted = np.concatenate([np.zeros(n_base), qd])
            lower, upper = self._bounds(state.q, self.model.velocities(last))
            yield self.model.command(np.minimum(np.maximum(wanted, lower), upper))

    def _report(self, goal: PoseGoal | PostureGoal) -> StepReport:
        where = left_to(goal, self.model, self.settings, self._now.state)
        unreachable = "" if where.arrived else self._unreachable
        return replace(where, base_time=self._left, unreachable=unreachable, planning=self._plans)
