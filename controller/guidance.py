"""Guidance out of local minima: leads base and arm to a stance that is known to reach the goal.

The QP of one period moves the end effector straight to its goal, and stops where limits or
obstacles leave no velocity that brings it nearer. A stance, a base pose with an arm posture in
which the end effector is at the goal, has no such minimum: base and arm can be led there each on
its own way. So a goal that is far away gets a stance, which is searched while the robot rests; one
that is near gets one if the end effector makes no progress. `guidance_states.Event` says what
follows what. Every period gives the QP a `StanceBias`, or leaves it to the end effector alone.
"""

from dataclasses import replace
from math import inf
from typing import NamedTuple

from config.planar import Pose2D
from config.poses import MapPose
from controller.collision.collision_model import CollisionModels
from controller.collision.self_collision import SelfCollision
from controller.command import Array, BaseGoal, PoseGoal
from controller.floor.base_drive import Lead
from controller.floor.floor_map import FloorMap
from controller.guidance_states import (
    NOTHING_TRIED,
    Alone,
    Approaching,
    Attempt,
    Event,
    Replacing,
    Searching,
    State,
    Unjudged,
    Unreachable,
)
from controller.model import RobotModel
from controller.servo import PoseError
from controller.settings import ControllerSettings
from controller.stance.bias import Remaining, StanceBias
from controller.stance.dexterity import dexterity
from controller.stance.finder import StanceFinder
from controller.stance.next_goal import NextGoalApproach
from controller.stance.progress import Progress
from controller.stance.search import StanceSearch
from controller.stance.stance import Stance
from controller.stance.stance_approach import Approach
from controller.surroundings import OPEN_FLOOR, Surroundings

_MAX_REST = 50
"""Periods (0.5 s) for which the robot rests for searches. Each jump of a goal begins another one:
to a goal that jumps all the time it would never move."""


class _Period(NamedTuple):
    """What is so in one period."""

    goal: PoseGoal[MapPose]
    error: PoseError  # of the end effector
    distance: float  # of the end effector to the goal, rotation included [m]
    mTb: Pose2D
    q: Array  # (j,) joint positions [rad]


class GuidanceResult(NamedTuple):
    """What guidance says of one period."""

    bias: StanceBias | None = None  # None leaves the motion to the end effector, or it rests
    reusable: bool = False  # whether the bias may be used again, on a free way to the stance
    age: int = 1  # periods since it was computed
    bearing: float = 0.0
    """Of the end effector, seen from the base, in the last stance, else as the robot prefers it
    [rad]."""
    base: Pose2D | None = None  # base pose of the stance, if there is one
    remaining: tuple[float, float] = (0.0, 0.0)
    """Least time of the base [s] and largest joint error [rad] to the stance with which the period
    began; 0 without one, and infinite at rest but in the period that ends the motion."""


class Guidance:
    """Guides to successive goals; `settings.guidance` is not None."""

    def __init__(
        self,
        model: RobotModel,
        settings: ControllerSettings,
        collision: SelfCollision,
        models: CollisionModels | None = None,
    ) -> None:
        assert settings.guidance is not None
        self._settings, self._guidance = settings, settings.guidance
        self._finder = StanceFinder(model, collision, models or CollisionModels(model))
        self._approach = Approach(model, settings, self._finder)
        self._progress = Progress(settings)
        self.departure = NextGoalApproach(model, settings, self._finder)
        self.waits = False  # whether the robot gives way to a moving obstacle, which is no stall
        self._bearing = dexterity(model.description).bearing  # that the robot prefers
        self._result = GuidanceResult(bearing=self._bearing)
        self.reset()

    def prepare(self, surroundings: Surroundings) -> None:
        """Compute in advance what the first step among these fixtures needs."""
        self._finder.update_map(surroundings.fixtures)

    def reset(self, *, keeps_bearing: bool = False) -> None:
        """Forget the goal: the next one is new."""
        self.state: State = Unjudged()
        self._attempt = NOTHING_TRIED
        self._result = GuidanceResult(
            bearing=self._result.bearing if keeps_bearing else self._bearing
        )
        self._approach.reset()
        self.departure.reset()

    def step(
        self,
        goal: PoseGoal[MapPose],
        error: PoseError,
        mTb: Pose2D,
        q: Array,
        surroundings: Surroundings = OPEN_FLOOR,
    ) -> GuidanceResult:
        """Guide for one period; `error` is of the end effector, `q` (j,) are in [rad]."""
        moved = self._finder.update(surroundings)
        if moved:
            self.departure.reset()
        elif self._can_reuse_bias(goal):
            self._result = self._result._replace(age=self._result.age + 1)
            return self._result
        goal = replace(goal, target=goal.target.copy())  # it is kept, and the caller's may change
        distance = error.position + self._guidance.metres_per_radian * error.orientation
        now = _Period(goal, error, distance, mTb, q)
        if moved or self._is_new(goal, distance):
            self._judge(now)
        else:
            self._attempt = self._attempt._replace(goal=goal)
        if not moved:  # a new map is work enough for one period
            self._advance_search()
        self._result = self._approach_stance(now)
        return self._result

    def lead_base(self, goal: BaseGoal[MapPose], mTb: Pose2D, surroundings: Surroundings) -> Lead:
        """Where the base is led now on its way to a base goal."""
        self._finder.update(surroundings)
        target = Pose2D.of(goal.target)
        if obstacle := self._finder.obstacle_to_base(target):
            return Lead.nowhere(goal.reverse, obstacle)
        return self._approach.route.lead(self._finder.floor, mTb, target, goal.reverse)

    @property
    def rests(self) -> bool:
        """Whether the robot must stop: the goal is out of reach, or its stance not known yet."""
        if isinstance(self.state, Searching):
            return self.state.periods <= _MAX_REST
        return isinstance(self.state, Unreachable)

    @property
    def unreachable(self) -> str:
        """Why the goal cannot be reached; empty if it can, as far as is known."""
        return self.state.why if isinstance(self.state, Unreachable) else ""

    @property
    def stance(self) -> Stance | None:
        """Where base and arm are led; None for the end effector alone."""
        return self.state.stance if isinstance(self.state, Approaching | Replacing) else None

    @property
    def detour(self) -> bool:
        """Whether the stance is a detour, the end effector waiting."""
        return isinstance(self.state, Approaching | Replacing) and self.state.is_detour

    @property
    def floor(self) -> FloorMap:
        """Map of the static obstacles."""
        return self._finder.floor

    @property
    def way(self) -> Array:
        """(N, 3) base poses on the path."""
        return self._approach.route.way

    def _go(self, event: Event, state: State) -> None:
        """Take the state that follows an event, as `Event` has it."""
        assert event.changes.get(type(self.state)) is type(state), (event, self.state, state)
        self.state = state
        self._progress.restart()

    def _can_reuse_bias(self, goal: PoseGoal[MapPose]) -> bool:
        """Whether the last bias may be used for a goal once more."""
        last, result = self._attempt.goal, self._result
        is_old = result.age >= self._settings.slow_periods
        if not result.reusable or is_old or goal.twist is not None:
            return False
        asked, before = ((one.speed, one.straight, one.hand_may_touch) for one in (goal, last))
        return asked == before and goal.target == last.target

    def _is_new(self, goal: PoseGoal[MapPose], distance: float) -> bool:
        """Whether a goal must be judged, or judged anew."""
        attempt, last, g = self._attempt, self._attempt.goal, self._guidance
        if isinstance(self.state, Unjudged):
            return True
        if self.unreachable and goal.hand_may_touch != last.hand_may_touch:
            return True
        if self._approach.base_follows(goal) and not self._approach.base_follows(last):
            return True
        if goal.target != last.target:
            return attempt.has_jumped(goal.target, g) or attempt.has_drifted(goal.target, g)
        return self._progress.was_close and distance > g.stance_distance and not goal.is_moving

    def _judge(self, now: _Period) -> None:
        """Take a new goal, and search its stance if it is to have one."""
        g, goal = self._guidance, now.goal
        before = None if self._attempt.has_jumped(goal.target, g) else self.stance
        rested = self.state.periods if isinstance(self.state, Searching) else 0
        self.state, self._attempt = Unjudged(), Attempt(goal.target, goal, g.detours)
        self._approach.restart()
        if now.distance >= g.close_distance and (why := self._finder.obstacle_to(goal, now.mTb)):
            self._go(Event.OUT_OF_REACH, Unreachable(why=why))
        elif goal.straight or not (goal.stance_if_near or now.distance > g.stance_distance):
            self._go(Event.NEAR, Alone())
        elif (stance := self.departure.stance_for(goal.target)) is not None:
            self._go(Event.SET_OUT, Approaching(stance=stance, is_detour=False))
        elif before is not None:
            search = self._search(now)
            self._go(Event.DRIFTED, Replacing(before, search, is_detour=False, for_detour=False))
        else:
            self._go(Event.FAR, Searching(self._search(now), for_detour=False, periods=rested))

    def _search(self, now: _Period) -> StanceSearch:
        where = now.goal.target, now.mTb, now.q, self._attempt.failed, now.goal.next_goal
        return self._finder.search(*where, in_front=self._approach.base_follows(now.goal))

    def _advance_search(self) -> None:
        """Do one piece of the search, and take its result when it is over."""
        state = self.state
        if not isinstance(state, Searching | Replacing):
            return
        search, for_detour = state.search, state.for_detour
        search.advance()
        stance = search.best
        if search.done and (why := self._finder.why_none(search)):
            self._go(Event.NONE_FREE, Unreachable(why=why))
        elif search.done and stance is not None:
            self._go(Event.FOUND, Approaching(stance, is_detour=for_detour))
        elif isinstance(state, Searching) and search.chosen and stance is not None:
            refined = Replacing(stance, search, is_detour=for_detour, for_detour=for_detour)
            self._go(Event.CHOSEN, refined)
        elif isinstance(state, Searching):
            self.state = state._replace(periods=state.periods + 1)

    def _approach_stance(self, now: _Period) -> GuidanceResult:
        """Approach the stance; take another where the base has no way, or nothing progresses."""
        goal, stance, base = now.goal, self.stance, None
        if stance is None:
            bearing, remaining = self._result.bearing, Remaining(now.distance)
        else:
            bearing, base = stance.bearing, stance.base_for(goal.target)
            remaining = self._approach.remaining(stance, base, goal, now.distance, now.mTb, now.q)
            if remaining.lead.unreachable:
                self._handle_no_way(now, remaining.lead.unreachable)
        if self.rests:
            return GuidanceResult(bearing=bearing, remaining=(inf, inf))
        is_over = goal.is_moving or now.distance < self._guidance.close_distance
        if isinstance(self.state, Approaching) and self.state.is_detour and is_over:
            self._go(Event.CLOSE, self.state._replace(is_detour=False))
        age, moves = self._result.age, goal.is_moving
        if self._progress.has_stalled(remaining, age, goal_moves=moves, waits=self.waits):
            self._handle_stall(now)
        left = remaining.lead.time_left, remaining.max_joint_error
        if stance is None or self.stance is None:
            return GuidanceResult(bearing=bearing, remaining=left)
        mTb, q, detour = now.mTb, now.q, self.detour
        bias = self._approach.bias(remaining, stance, goal, now.error, mTb, q, detour=detour)
        on_free_way = remaining.lead.final and not remaining.hand_waits and goal.twist is None
        reusable = on_free_way and isinstance(self.state, Approaching)
        return GuidanceResult(bias, reusable, bearing=bearing, base=base, remaining=left)

    def _handle_no_way(self, now: _Period, why: str) -> None:
        """The base does not get to the stance: search another one."""
        state = self.state
        if isinstance(state, Replacing):
            self._go(Event.NO_WAY, Searching(state.search, for_detour=state.for_detour))
        elif search := self._search_another(now):
            self._go(Event.NO_WAY, Searching(search, for_detour=self.detour))
        else:
            self._go(Event.CUT_OFF, Unreachable(why=why))

    def _handle_stall(self, now: _Period) -> None:
        """There is no progress: search a stance for a detour."""
        state, straight = self.state, now.goal.straight
        if straight or not self._attempt.detours_left or not isinstance(state, Alone | Approaching):
            return
        if (search := self._search_another(now)) is None:
            self._go(Event.GIVEN_UP, Alone())
        elif isinstance(state, Alone):
            self._go(Event.STALLED, Searching(search, for_detour=True))
        else:
            stance, is_detour = state
            self._go(Event.STALLED, Replacing(stance, search, is_detour, for_detour=True))

    def _search_another(self, now: _Period) -> StanceSearch | None:
        """The search for another stance after a failure, unless there were enough."""
        self._attempt = self._attempt.failing(self.stance)
        return self._search(now) if self._attempt.detours_left else None
