"""Guidance out of local minima: leads base and arm to a stance that is known to reach the goal."""

from math import cos, inf

import numpy as np
from pinocchio import SE3

from controller.collision.collision_model import CollisionModels
from controller.collision.self_collision import SelfCollision
from controller.command import Array, BaseGoal, PoseGoal
from controller.floor.base_drive import Lead, Pose2D
from controller.floor.floor_map import FloorMap
from controller.floor.route import Route
from controller.model import RobotModel
from controller.servo import PoseError
from controller.settings import ControllerSettings
from controller.stance.approach import Approach
from controller.stance.bias import Remaining, StanceBias, bias_towards
from controller.stance.finder import StanceFinder
from controller.stance.moving_goal import MovingGoalFollower, is_followed
from controller.stance.next_goal import NextGoalApproach
from controller.stance.search import StanceSearch
from controller.stance.stance import Stance
from controller.surroundings import OPEN_FLOOR, Surroundings

_MAX_REST = 50  # periods after which a robot whose goal changes all the time moves without a stance


class Guidance:
    """Keeps the stance of one goal from period to period; `settings.guidance` is not None."""

    def __init__(
        self,
        model: RobotModel,
        settings: ControllerSettings,
        collision: SelfCollision,
        models: CollisionModels | None = None,
    ) -> None:
        self._model = model
        self._settings = settings
        assert settings.guidance is not None
        self._guidance = settings.guidance
        self._finder = StanceFinder(model, collision, models or CollisionModels(model))
        self._min_turn_cosine = cos(self._guidance.goal_turn)
        self._route = Route(model, settings)
        self._base_goal, self._base_obstacle = Pose2D(inf, inf, inf), ""
        self._approach = Approach(model, settings.guidance, self._route)
        self._follower = MovingGoalFollower(model, settings) if is_followed(model) else None
        self.next_goal = NextGoalApproach(model, settings, self._finder)
        self._hand_may_touch = self._follows = False
        self.waits = False  # whether the robot gives way to a moving obstacle, which is no stall
        self.reset()

    def prepare(self, surroundings: Surroundings) -> None:
        """Compute in advance what the first step among these fixtures needs."""
        self._finder.update_map(surroundings.fixtures)

    def reset(self, *, keeps_bearing: bool = False) -> None:
        """Forget the goal: the next one is new."""
        if not keeps_bearing:
            self.bearing = 0.0  # of the end effector, seen from the base, in the last stance [rad]
        self.remaining = (0.0, 0.0)
        """Least time of the base [s] and largest joint error [rad] to the stance; 0 without one."""
        self.unreachable = ""  # why the goal cannot be reached; empty if it can, as far as is known
        self._goal: SE3 | None = None
        self._base = Pose2D(0.0, 0.0, 0.0)
        self._base_of: tuple[Stance | None, SE3 | None] = (None, None)
        self._first_goal: SE3 | None = None
        self._searched = 0
        if self._follower is not None:
            self._follower.reset()
        self.next_goal.reset()
        self._start_goal(None)
        self._set_stance(None)
        self._asked: tuple[object, ...] = ()  # of the last goal, besides its pose
        self._bias: StanceBias | None = None
        self._age = 0  # of the bias [periods]
        self._lasts = False  # whether it may be used again, on a free way to the stance

    @property
    def base(self) -> Pose2D | None:
        """Base pose of the stance, if there is one."""
        return None if self.stance is None else self._base

    @property
    def floor(self) -> FloorMap:
        """Map of the static obstacles."""
        return self._finder.floor

    @property
    def way(self) -> Array:
        """(N, 3) base poses on the path."""
        return self._route.way

    @property
    def rests(self) -> bool:
        """Whether the robot must stop: the goal is out of reach, or its stance not known yet."""
        searches = self._search is not None and self.stance is None
        return bool(self.unreachable) or (searches and self._searched <= _MAX_REST)

    def _start_goal(self, wTe: SE3 | None) -> None:
        self._approach.reset()
        self._first_goal = wTe
        self._failed: tuple[Stance, ...] = ()
        self._detours_left = self._guidance.detours
        self._search: StanceSearch | None = None
        self._stalled = False
        self._was_close = False
        """Whether the goal was nearly reached: a robot that has to leave it starts anew."""

    def _set_stance(self, stance: Stance | None, detour: bool = False) -> None:
        if stance is not None:
            self.bearing = stance.bearing
        self.stance = stance  # where base and arm are led; None for the end effector alone
        self.detour = detour  # whether the stance is a detour, the end effector waiting
        self._best = (inf, inf, inf)
        self._stage = False, False
        self._waited = 0

    def bias(
        self,
        goal: PoseGoal,
        error: PoseError,
        wTb: Pose2D,
        q: Array,
        surroundings: Surroundings = OPEN_FLOOR,
    ) -> StanceBias | None:
        """The bias of one period towards the goal's stance; None without one, or if it `rests`.

        `error` is that of the end effector, `q` are the joint positions (j,) [rad].
        """
        g = self._guidance
        distance = error.position + g.metres_per_radian * error.orientation
        self._age += 1
        if moved := self._finder.update(surroundings):
            self.next_goal.reset()
        asked = goal.speed, goal.straight, goal.hand_may_touch
        same = asked == self._asked and goal.twist is None and goal.wTe == self._goal
        if self._lasts and same and not moved and self._age < self._settings.slow_periods:
            return self._bias
        self._asked, self._lasts = asked, False
        passed, self._age = self._age, 0
        changed = moved or (bool(self.unreachable) and goal.hand_may_touch != self._hand_may_touch)
        follows = goal.is_moving and not goal.straight and self._follower is not None
        changed = changed or (follows and not self._follows)
        self._hand_may_touch, self._follows = goal.hand_may_touch, follows
        if goal.wTe != self._goal or changed:
            if self._is_new(goal.wTe) or changed:
                self._begin(goal, distance, wTb, q)
            self._goal = goal.wTe.copy()
        elif self._was_close and distance > g.min_distance and not goal.is_moving:
            self._begin(goal, distance, wTb, q)
        if not moved:  # a new map is work enough for one period
            self._advance_search()
        remaining = self._remaining(goal, distance, wTb, q)
        if remaining.lead is not None and remaining.lead.unreachable:
            self._give_up_stance(goal, wTb, q)
            if self._search is None:
                self.unreachable = remaining.lead.unreachable
        if self.rests:
            self.remaining = (inf, inf)
            return None
        if self._has_stalled(remaining, goal, passed) and not goal.straight and self._detours_left:
            stance, detour = self.stance, self.detour
            self._give_up_stance(goal, wTb, q)
            self._stalled = True
            if self._search is not None:
                self._set_stance(stance, detour)  # until another is found
        self.remaining = (remaining.base_time, remaining.max_joint_error)
        if self.stance is None or remaining.lead is None:
            return None
        following = None
        if self._follows and self._follower is not None:
            following = self._follower(self.stance, goal, error, wTb, q)
        model, settings, detour = self._model, self._settings, self.detour
        self._bias = bias_towards(
            model, settings, remaining, goal, wTb, q, detour=detour, following=following
        )
        waits = remaining.in_transport or remaining.docks or goal.twist is not None
        self._lasts = remaining.lead.final and self._search is None and not waits
        return self._bias

    def lead_base(self, goal: BaseGoal, wTb: Pose2D, surroundings: Surroundings) -> Lead:
        """Where the base is led now on its way to a base goal."""
        there = Pose2D.of(goal.wTb)
        if self._finder.update(surroundings) or there != self._base_goal:
            self._base_goal, self._base_obstacle = there, self._finder.obstacle_to_base(there)
        if self._base_obstacle:
            still = Pose2D(0.0, 0.0, 0.0)
            return Lead(still, goal.reverse, False, 0.0, inf, unreachable=self._base_obstacle)
        return self._route.lead(self._finder.floor, wTb, there, goal.reverse)

    def _begin(self, goal: PoseGoal, distance: float, wTb: Pose2D, q: Array) -> None:
        """Judge a new goal, and search its stance if it is to have one."""
        crept = self._first_goal is not None and not self._has_jumped(goal.wTe)
        self._start_goal(goal.wTe.copy())
        self._set_stance(self.stance if crept else None)
        is_there = distance < self._guidance.close
        self.unreachable = "" if is_there else self._finder.obstacle_to(goal, wTb)
        if self.unreachable:
            self._set_stance(None)
        elif not goal.straight and (goal.stance_if_near or distance > self._guidance.min_distance):
            self._set_stance(self.next_goal.stance_for(goal.wTe) or self.stance)
            if self.stance is None or crept:
                self._start_search(goal, wTb, q)
        else:
            self._set_stance(None)

    def _give_up_stance(self, goal: PoseGoal, wTb: Pose2D, q: Array) -> None:
        """Search another stance, unless that was done often enough."""
        if self.stance is not None:
            self._failed = (*self._failed, self.stance)
        self._set_stance(None)
        self._detours_left = max(0, self._detours_left - 1)
        if self._detours_left:
            self._start_search(goal, wTb, q)

    def _start_search(self, goal: PoseGoal, wTb: Pose2D, q: Array) -> None:
        wTe, failed, follows = goal.wTe.copy(), self._failed, self._follows
        self._search = self._finder.search(wTe, wTb, q, failed, goal.next_goal, in_front=follows)

    def _advance_search(self) -> None:
        """Do one piece of the search, and take its result when it is over."""
        search = self._search
        self._searched = 0 if search is None else self._searched + 1
        if search is None:
            return
        search.advance()
        if search.done:
            self._search = None
            self.unreachable = self._finder.why_none(search)
            self._set_stance(None if self.unreachable else search.best, self._stalled)
        elif search.chosen and self.stance is None:
            self._set_stance(search.best)

    def _is_new(self, wTe: SE3) -> bool:
        """Whether a goal has jumped, or crept to where its stance does not reach it."""
        if self._first_goal is None or self._has_jumped(wTe):
            return True
        g = self._guidance
        rise = float(wTe.translation[2] - self._first_goal.translation[2])
        tilt = float(wTe.rotation[2] @ self._first_goal.rotation[2])
        return abs(rise) > g.goal_rise or tilt < g.goal_tilt

    def _has_jumped(self, wTe: SE3) -> bool:
        if self._goal is None:
            return True
        g, moved = self._guidance, wTe.translation - self._goal.translation
        cosine = (float(np.vdot(wTe.rotation, self._goal.rotation)) - 1.0) / 2.0
        return float(moved @ moved) > g.goal_jump * g.goal_jump or cosine < self._min_turn_cosine

    def _remaining(self, goal: PoseGoal, distance: float, wTb: Pose2D, q: Array) -> Remaining:
        stance = self.stance
        if stance is None:
            return Remaining(distance)
        if stance is not self._base_of[0] or self._goal is not self._base_of[1]:
            self._base, self._base_of = stance.base_for(goal.wTe), (stance, self._goal)
        floor, space, follows = self._finder.floor, self._finder.space, goal.is_moving
        base = wTb if self._model.description.stands_still else self._base
        return self._approach.remaining(
            stance, base, distance, wTb, q, floor, space, follows=follows
        )

    def _has_stalled(self, remaining: Remaining, goal: PoseGoal, passed: int) -> bool:
        """Whether end effector, base and arm have made no progress for a while.

        It was asked last `passed` periods ago. On a way among obstacles only progress of the base
        counts. A robot that follows a moving goal or waits for a moving obstacle never stalls.
        """
        g = self._guidance
        if remaining.distance < g.close or goal.is_moving:
            self._was_close = remaining.distance < g.close
            self._set_stance(self.stance)
            return False
        stage = remaining.in_transport, remaining.docks
        if stage != self._stage:
            self._stage, self._best = stage, (inf, inf, inf)
        drives_far = remaining.lead is not None and not remaining.lead.final
        if drives_far and not remaining.in_transport:  # whatever the arm does meanwhile
            left = inf, remaining.base_time, inf
        else:
            left = remaining.distance, remaining.base_time, remaining.max_joint_error
        a, b, c = self._best
        x, y, z = left
        if x < a - g.progress or y < b - g.progress or z < c - g.progress:
            self._best = min(a, x), min(b, y), min(c, z)
            self._waited = 0
        elif not self.waits:
            self._waited += passed
        return self._waited * self._settings.period >= g.patience
