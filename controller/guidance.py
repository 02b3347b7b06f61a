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
    Attempt,
    Event,
    Led,
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
from controller.stance.finder import StanceFinder
from controller.stance.next_goal import NextGoalApproach
from controller.stance.progress import Progress
from controller.stance.search import StanceSearch
from controller.stance.stance import Stance
from controller.stance.stance_approach import Approach
from controller.surroundings import OPEN_FLOOR, Surroundings

_MAX_REST = 50  # periods after which a robot whose goal changes all the time moves without a stance


class Guided(NamedTuple):
    """What one period has given."""

    bias: StanceBias | None = None  # None leaves the motion to the end effector, or it rests
    lasts: bool = False  # whether the bias may be used again, on a free way to the stance
    age: int = 1  # periods since it was computed
    bearing: float = 0.0  # of the end effector, seen from the base, in the last stance [rad]
    base: Pose2D | None = None  # base pose of the stance, if there is one
    remaining: tuple[float, float] = (0.0, 0.0)
    """Least time of the base [s] and largest joint error [rad] to the stance; 0 without one, and
    infinite at rest."""


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
        self.next_goal = NextGoalApproach(model, settings, self._finder)
        self.waits = False  # whether the robot gives way to a moving obstacle, which is no stall
        self._guided = Guided()
        self.reset()

    def prepare(self, surroundings: Surroundings) -> None:
        """Compute in advance what the first step among these fixtures needs."""
        self._finder.update_map(surroundings.fixtures)

    def reset(self, *, keeps_bearing: bool = False) -> None:
        """Forget the goal: the next one is new."""
        self.state: State = Unjudged()
        self._attempt = NOTHING_TRIED
        self._guided = Guided(bearing=self.bearing if keeps_bearing else 0.0)
        self._approach.reset()
        self.next_goal.reset()

    def bias(
        self,
        goal: PoseGoal[MapPose],
        error: PoseError,
        mTb: Pose2D,
        q: Array,
        surroundings: Surroundings = OPEN_FLOOR,
    ) -> StanceBias | None:
        """The bias of one period towards the goal's stance; None without one, or if it `rests`.

        `error` is that of the end effector, `q` are the joint positions (j,) [rad].
        """
        moved = self._finder.update(surroundings)
        if moved:
            self.next_goal.reset()
        if not moved and self._lasts_for(goal):
            self._guided = self._guided._replace(age=self._guided.age + 1)
            return self._guided.bias
        goal = replace(goal, target=goal.target.copy())  # it is kept, and the caller's may change
        distance = error.position + self._guidance.metres_per_radian * error.orientation
        if moved or self._is_new(goal, distance):
            self._judge(goal, distance, mTb, q)
        else:
            self._attempt = self._attempt._replace(goal=goal)
        if not moved:  # a new map is work enough for one period
            self._advance_search()
        self._guided = self._guide(goal, error, distance, mTb, q)
        return self._guided.bias

    def lead_base(self, goal: BaseGoal[MapPose], mTb: Pose2D, surroundings: Surroundings) -> Lead:
        """Where the base is led now on its way to a base goal."""
        self._finder.update(surroundings)
        there = Pose2D.of(goal.target)
        if obstacle := self._finder.obstacle_to_base(there):
            return Lead.nowhere(goal.reverse, obstacle)
        return self._approach.route.lead(self._finder.floor, mTb, there, goal.reverse)

    @property
    def rests(self) -> bool:
        """Whether the robot must stop: the goal is out of reach, or its stance not known yet."""
        state = self.state
        waits = isinstance(state, Searching) and state.periods <= _MAX_REST
        return waits or isinstance(state, Unreachable)

    @property
    def unreachable(self) -> str:
        """Why the goal cannot be reached; empty if it can, as far as is known."""
        return self.state.why if isinstance(self.state, Unreachable) else ""

    @property
    def stance(self) -> Stance | None:
        """Where base and arm are led; None for the end effector alone."""
        return self.state.stance if isinstance(self.state, Led | Replacing) else None

    @property
    def detour(self) -> bool:
        """Whether the stance is a detour, the end effector waiting."""
        return isinstance(self.state, Led | Replacing) and self.state.detour

    @property
    def base(self) -> Pose2D | None:
        """Base pose of the stance, if there is one."""
        return self._guided.base

    @property
    def bearing(self) -> float:
        """Of the end effector, seen from the base, in the last stance [rad]."""
        return self._guided.bearing

    @property
    def remaining(self) -> tuple[float, float]:
        """Least time of the base [s] and largest joint error [rad] to the stance; see `Guided`."""
        return self._guided.remaining

    @property
    def floor(self) -> FloorMap:
        """Map of the static obstacles."""
        return self._finder.floor

    @property
    def way(self) -> Array:
        """(N, 3) base poses on the path."""
        return self._approach.route.way

    def _go(self, event: Event, *contents: object) -> None:
        """Take the state that follows an event, with these contents."""
        self.state = event.changes[type(self.state)](*contents)
        self._progress.restart()

    def _lasts_for(self, goal: PoseGoal[MapPose]) -> bool:
        """Whether the last bias may be used for a goal once more."""
        guided = self._guided
        if not guided.lasts or guided.age >= self._settings.slow_periods or goal.twist is not None:
            return False
        last = self._attempt.goal
        asked, before = ((one.speed, one.straight, one.hand_may_touch) for one in (goal, last))
        return asked == before and goal.target == last.target

    def _is_new(self, goal: PoseGoal[MapPose], distance: float) -> bool:
        """Whether a goal must be judged, or judged anew."""
        attempt, last, g = self._attempt, self._attempt.goal, self._guidance
        if isinstance(self.state, Unjudged):
            return True
        if self.unreachable and goal.hand_may_touch != last.hand_may_touch:
            return True
        if self._approach.follows(goal) and not self._approach.follows(last):
            return True
        if goal.target != last.target:
            return attempt.has_jumped(goal.target, g) or attempt.has_drifted(goal.target, g)
        return self._progress.was_close and distance > g.min_distance and not goal.is_moving

    def _judge(self, goal: PoseGoal[MapPose], distance: float, mTb: Pose2D, q: Array) -> None:
        """Take a new goal, and search its stance if it is to have one."""
        g = self._guidance
        before = None if self._attempt.has_jumped(goal.target, g) else self.stance
        rested = self.state.periods if isinstance(self.state, Searching) else 0
        self.state, self._attempt = Unjudged(), Attempt(goal.target, goal, g.detours)
        self._approach.restart()
        if distance >= g.close and (why := self._finder.obstacle_to(goal, mTb)):
            self._go(Event.OUT_OF_REACH, why)
        elif goal.straight or not (goal.stance_if_near or distance > g.min_distance):
            self._go(Event.NEAR)
        elif (stance := self.next_goal.stance_for(goal.target)) is not None:
            self._go(Event.SET_OUT, stance)
        elif before is not None:
            self._go(Event.DRIFTED, before, False, self._search(mTb, q))
        else:
            self._go(Event.FAR, self._search(mTb, q), False, rested)

    def _search(self, mTb: Pose2D, q: Array) -> StanceSearch:
        goal, failed = self._attempt.goal, self._attempt.failed
        follows = self._approach.follows(goal)
        return self._finder.search(goal.target, mTb, q, failed, goal.next_goal, in_front=follows)

    def _advance_search(self) -> None:
        """Do one piece of the search, and take its result when it is over."""
        state = self.state
        if not isinstance(state, Searching | Replacing):
            return
        search = state.search
        search.advance()
        if search.done:
            if why := self._finder.why_none(search):
                self._go(Event.NONE_FREE, why)
            else:
                self._go(Event.FOUND, search.best, state.for_detour)
        elif isinstance(state, Searching):
            if search.chosen:
                self._go(Event.CHOSEN, search.best, state.for_detour, search, state.for_detour)
            else:
                self.state = state._replace(periods=state.periods + 1)

    def _guide(
        self, goal: PoseGoal[MapPose], error: PoseError, distance: float, mTb: Pose2D, q: Array
    ) -> Guided:
        """Lead to the stance, and notice where that leads to none."""
        stance, base = self.stance, None
        if stance is None:
            bearing, remaining = self.bearing, Remaining(distance)
        else:
            bearing, base = stance.bearing, stance.base_for(goal.target)
            remaining = self._approach.remaining(stance, base, goal, distance, mTb, q)
            if remaining.lead.unreachable:
                self._have_no_way(remaining.lead.unreachable, mTb, q)
        if self.rests:
            return Guided(bearing=bearing, remaining=(inf, inf))
        is_over = goal.is_moving or distance < self._guidance.close
        if isinstance(self.state, Led) and self.state.detour and is_over:
            self._go(Event.CLOSE, stance)
        passed, follows = self._guided.age, goal.is_moving
        if self._progress.has_stalled(remaining, passed, follows=follows, waits=self.waits):
            self._have_stalled(goal, mTb, q)
        left = remaining.lead.time_left, remaining.max_joint_error
        if stance is None or self.stance is None:
            return Guided(bearing=bearing, remaining=left)
        bias = self._approach.bias(remaining, stance, goal, error, mTb, q, detour=self.detour)
        on_free_way = isinstance(self.state, Led) and remaining.lead.final and not remaining.waits
        return Guided(bias, on_free_way and goal.twist is None, 1, bearing, base, left)

    def _have_no_way(self, why: str, mTb: Pose2D, q: Array) -> None:
        state = self.state
        if isinstance(state, Replacing):
            self._go(Event.NO_WAY, state.search, state.for_detour)
        elif search := self._search_another(mTb, q):
            self._go(Event.NO_WAY, search, self.detour)
        else:
            self._go(Event.CUT_OFF, why)

    def _have_stalled(self, goal: PoseGoal[MapPose], mTb: Pose2D, q: Array) -> None:
        state = self.state
        if goal.straight or not self._attempt.detours_left or not isinstance(state, Alone | Led):
            return
        search = self._search_another(mTb, q)
        if search is None:
            self._go(Event.GIVEN_UP)
        else:
            self._go(Event.STALLED, *state, search, True)

    def _search_another(self, mTb: Pose2D, q: Array) -> StanceSearch | None:
        """The search for another stance after a failure, unless there were enough."""
        self._attempt = self._attempt.failing(self.stance)
        return self._search(mTb, q) if self._attempt.detours_left else None
