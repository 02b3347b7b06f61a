"""The planning controller: base first, then the arm; the baseline for the holistic controller.

For a pose goal the arm folds, the base drives to a stance, and the arm follows a planned
trajectory, one after the other and each from rest. A goal that moves a little meanwhile is planned
anew only afterwards. Plans take moving obstacles as they are at that time, and ignore depth points.
"""

from collections.abc import Generator, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from config.arrays import Array
from config.planar import Pose2D
from config.poses import MapPose
from controller import (
    OPEN_FLOOR,
    BaseGoal,
    CollisionModels,
    Command,
    HolisticController,
    KinematicState,
    MotionGoal,
    PoseGoal,
    PostureGoal,
    RobotModel,
    SelfCollision,
    Stance,
    StanceFinder,
    StepReport,
    Surroundings,
    VelocityBounds,
    linearise,
    pose_error,
    se3_of,
)
from lab.bench.planning.arm_planner import ArmPlanner, PlanningSettings
from lab.bench.planning.trajectory import Trajectory

_AT_REST = 1e-3  # slower commands count as rest [m/s and rad/s]
_LAGS = 4.0  # time until the robot rests after its last command [time constants]
_PROGRESS = 0.01  # least progress of the base [m and s]


class _Now(NamedTuple):
    """Inputs of the present period."""

    state: KinematicState
    last: Command
    surroundings: Surroundings


class _NoWayError(Exception):
    """A goal cannot be reached; the text says why."""


_Commands = Generator[Command, None, None]  # one command a period


class PlanningController(HolisticController):
    """Turns goals into velocities by plans; as a holistic controller it drives the base.

    Raises:
        PlanningError: the planning library is not installed.
    """

    def __init__(self, model: RobotModel, planning: PlanningSettings | None = None) -> None:
        super().__init__(model)
        self._planning = planning or PlanningSettings()
        models = CollisionModels(model)
        self._arm = ArmPlanner(model, self._planning, self.settings.period, models)
        self._bounds = VelocityBounds(model, self.settings)
        self._finder = StanceFinder(model, SelfCollision(model), models)
        self._forget()

    def _forget(self) -> None:
        self._goal: MotionGoal[MapPose] | None = None
        self._commands: Iterator[Command] = iter(())
        self._unreachable = ""
        self._time_left = 0.0
        self.is_planning = False  # whether the robot stands because a motion is being planned
        self._attempts = 0

    def prepare(self, surroundings: Surroundings) -> None:
        """Compute in advance what the first step in these surroundings needs."""
        super().prepare(surroundings)
        self._finder.update_map(surroundings.fixtures)

    def step(
        self,
        state: KinematicState,
        goal: MotionGoal[MapPose] | None,
        last: Command,
        surroundings: Surroundings = OPEN_FLOOR,
    ) -> tuple[Command, StepReport]:
        """The command for the next period; see `HolisticController.step`."""
        if goal is None or isinstance(goal, BaseGoal):
            self._forget()
            return super().step(state, goal, last, surroundings)
        if self._is_other(goal):
            self._forget()
            self._goal, self._commands = goal, self._pursue(goal)
        self._now = _Now(state, last, surroundings)
        command = next(self._commands, None)
        if command is None:
            command = self._over(goal)
        return command, self._progress(goal)

    def _over(self, goal: PoseGoal[MapPose] | PostureGoal) -> Command:
        """Stay at a reached goal; plan again for one that has moved meanwhile."""
        reached, again = self._progress(goal).arrived, self._planning.attempts
        if not reached and not self._unreachable and self._attempts < again:
            self._goal, self._commands = goal, self._pursue(goal)
            return next(self._commands, self._rest())
        if not reached and not self._unreachable:
            self._unreachable = f"not there after {again} plans"
        self.is_planning, self._time_left = False, 0.0
        return self._rest()

    def _is_other(self, goal: PoseGoal[MapPose] | PostureGoal) -> bool:
        """Whether a goal differs from the planned one by more than a little."""
        known, settings = self._goal, self._planning
        if isinstance(goal, PoseGoal) and isinstance(known, PoseGoal):
            error = pose_error(known.target, goal.target)
            moved = error.position > settings.other_goal or error.orientation > settings.other_turn
            return moved or (bool(self._unreachable) and goal.straight != known.straight)
        if isinstance(goal, PostureGoal) and isinstance(known, PostureGoal):
            return bool(np.abs(goal.q - known.q).max() > goal.tolerance)
        return True

    def _pursue(self, goal: PoseGoal[MapPose] | PostureGoal) -> _Commands:
        """The commands to a goal."""
        self._attempts += 1
        self._time_left = np.inf
        try:
            yield from self._stop()
            if isinstance(goal, PostureGoal):
                yield from self._posture(goal.q)
            elif (plan := self._plan_to(goal)) is not None:
                yield from self._think()
                yield from self._follow(plan)
            elif goal.straight and goal.hand_may_touch:
                yield from self._straight_towards(goal)
            else:
                yield from self._drive_and_reach(goal)
        except _NoWayError as error:
            self._unreachable = str(error)

    def _plan_to(self, goal: PoseGoal[MapPose]) -> Trajectory | None:
        state, _, surroundings = self._now
        return self._arm.to_pose(state, goal, surroundings)

    def _straight_towards(self, goal: PoseGoal[MapPose]) -> _Commands:
        """A part of the straight line, as the hand is among things that it may touch."""
        state, _, surroundings = self._now
        part = self._arm.towards(state, goal, surroundings)
        yield from self._think()
        if part is not None:
            yield from self._follow(part)
        raise _NoWayError("the arm finds no way there from here")

    def _posture(self, q: Array) -> _Commands:
        """The arm to joint positions (j,)."""
        state, _, surroundings = self._now
        plan = self._arm.to_posture(state, q, surroundings)
        yield from self._think()
        if plan is None:
            raise _NoWayError("the arm finds no way to the posture")
        yield from self._follow(plan)

    def _drive_and_reach(self, goal: PoseGoal[MapPose]) -> _Commands:
        """Fold the arm, drive to a stance, and reach for the goal."""
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

    def _stance(self, goal: PoseGoal[MapPose], failed: tuple[Stance, ...]) -> Stance:
        state, _, surroundings = self._now
        self._finder.update(surroundings)
        mTb = Pose2D.of(state.mTb)
        if reason := self._finder.obstacle_to(goal, mTb):
            raise _NoWayError(reason)
        search = self._finder.search(goal.target, mTb, state.q, failed)
        stance = search.finish()
        if stance is None or (reason := self._finder.why_none(search)):
            raise _NoWayError(reason if stance is not None else "there is no place to stand")
        return stance

    def _drive(self, stance: Stance, goal: PoseGoal[MapPose]) -> Generator[Command, None, bool]:
        """The base to its place; whether it got there."""
        target = BaseGoal(target=se3_of(stance.base_for(goal.target)), reverse=stance.reverse)
        best, since = np.inf, 0
        while since * self.settings.period < self._planning.drive_patience:
            state, last, surroundings = self._now
            command, report = super().step(state, target, last, surroundings)
            if report.arrived or report.unreachable:
                return report.arrived
            self._time_left = report.base_time
            left = report.base_time + report.position_error
            since = 0 if left < best - _PROGRESS else since + 1
            best = min(left, best)
            yield command
        return False

    def _stop(self) -> _Commands:
        """Come to rest."""
        description = self.model.description
        lag = max(description.base.lag, description.arm.lag)
        waits = 0
        while waits * self.settings.period < _LAGS * lag:
            moves = np.abs(self.model.velocities(self._now.last)).max() > _AT_REST
            if not moves and waits == 0:
                return
            waits = 0 if moves else waits + 1
            yield self._rest()

    def _think(self) -> _Commands:
        """Stand for the planning time."""
        self.is_planning = True
        for _ in range(round(self._planning.planning_time / self.settings.period)):
            yield self._rest()
        self.is_planning = False

    def _rest(self) -> Command:
        state, last, surroundings = self._now
        return super().step(state, None, last, surroundings)[0]

    def _follow(self, plan: Trajectory) -> _Commands:
        """The joints along a plan, until they have settled."""
        settings, period = self._planning, self.settings.period
        late = round(self.model.description.arm.lag / period)
        n_base = self.model.n_base
        patience = round(settings.patience / period)
        for number in range(len(plan.q) + patience):
            state, last, _ = self._now
            self._time_left = max(0.0, plan.duration - number * period)
            error = plan.q[min(max(number - late, 0), len(plan.q) - 1)] - state.q
            over = number >= len(plan.q)
            if over and np.abs(error).max() < settings.settled:
                return
            qd = settings.gain * error
            if not over:
                qd = qd + plan.qd[number]
            wanted = np.concatenate([np.zeros(n_base), qd])
            lower, upper = self._bounds.at(state.q, self.model.velocities(last))
            yield self.model.command(np.minimum(np.maximum(wanted, lower), upper))

    def _progress(self, goal: PoseGoal[MapPose] | PostureGoal) -> StepReport:
        state = self._now.state
        kinematics = linearise(self.model, self.settings, state.q)
        if isinstance(goal, PostureGoal):
            position, angle = 0.0, float(np.abs(goal.q - state.q).max())
            arrived = angle <= goal.tolerance
        else:
            error = pose_error(state.mTb * kinematics.bTe, goal.target)
            position, angle = error.position, error.orientation
            arrived = position <= goal.position_tolerance and angle <= goal.orientation_tolerance
        return StepReport(
            manipulability=kinematics.manipulability,
            heading_error=kinematics.heading_error,
            bTe=kinematics.bTe,
            arrived=arrived,
            position_error=position,
            orientation_error=angle,
            base_time=self._time_left,
            unreachable="" if arrived else self._unreachable,
        )
