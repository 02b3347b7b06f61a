"""Plans whole motions of the arm among obstacles, the base at rest."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise, takewhile
from math import radians
from typing import TypeAlias

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from config.arrays import Array
from config.planar import Pose2D, wrap
from config.poses import MapPose
from controller import (
    REACHED,
    CollisionModel,
    CollisionModels,
    KinematicState,
    PairKind,
    PoseGoal,
    PostureBank,
    RobotModel,
    Surroundings,
    bank,
    refine_standing,
    unwound,
)
from lab.bench.planning.rrt import planning_library, rrt_connect
from lab.bench.planning.trajectory import Trajectory, timed


@dataclass(frozen=True, kw_only=True)
class PlanningSettings:
    """How motions are planned, and how trajectories are followed."""

    planning_time: float = 0.05
    """The robot stands for this long whenever a motion of the arm is planned [s], instead of the
    real computing time, so that the same seed is the same run."""
    checks: int = 6000  # largest number of contact checks of a search
    shortcuts: int = 60  # number of shortcuts that are tried on a path
    candidates: int = 4  # largest number of postures at the goal that are tried
    clearance: float = 0.01  # clearance of the arm, except where it starts or ends nearer [m]
    close_clearance: float = 0.001  # the same where the hand may touch obstacles [m]
    resolution: float = 0.03  # joint-space distance between checked postures of a path [rad]
    straight_step: float = 0.01  # distance between postures on a straight line of the hand [m]
    straight_jump: float = 0.35  # largest joint motion between two of them [rad]
    speed_share: float = 0.95  # share of the joint speeds that a plan uses ...
    acceleration_share: float = 0.85  # ... and of the joint accelerations
    gain: float = 5.0  # gain of the joint errors [1/s]
    settled: float = 0.002  # largest joint error at the end of a plan [rad] ...
    patience: float = 0.6  # ... unless this time has passed after it [s]
    folded: float = 0.3  # joint distance to the ready posture at which the base may drive [rad]
    drive_patience: float = 3.0  # time without progress after which the base is stuck [s]
    attempts: int = 3  # largest number of plans, and of stances, for one goal
    other_goal: float = 0.05  # a goal that has moved this far is a new goal [m] ...
    other_turn: float = radians(20.0)  # ... or has turned this far [rad]


_IsFree: TypeAlias = Callable[[Array], bool]  # whether a posture (j,) is free of contact

_ANY_SPEED = 10.0  # of the end effector, for motions without a speed limit [m/s]
_OF_THE_ARM = (PairKind.SELF, PairKind.ARM, PairKind.HAND, PairKind.PALM, PairKind.ARM_MOVING)
_SLACK = 1e-3  # by which a pair that starts nearer than the clearance may come nearer still [m]


class ArmPlanner:
    """Plans from the present posture.

    Raises:
        PlanningError: the library is not installed.
    """

    def __init__(
        self, model: RobotModel, settings: PlanningSettings, period: float, models: CollisionModels
    ) -> None:
        planning_library()
        self._model = model
        self._settings = settings
        self._period = period
        self._models = models
        self._bank = bank(model.description)
        self._seed = 0

    def to_posture(
        self, state: KinematicState, q: Array, surroundings: Surroundings
    ) -> Trajectory | None:
        """The arm to joint positions q (j,) [rad]; None if no path was found."""
        space = self._space(state.mTb, surroundings)
        is_free = space.test(state.q, hand_may_touch=False)
        return self._along(self._first(state.q, [q], lambda _: is_free), _ANY_SPEED)

    def to_pose(
        self, state: KinematicState, goal: PoseGoal[MapPose], surroundings: Surroundings
    ) -> Trajectory | None:
        """The hand to a pose, straight if the goal asks for it; None if no path was found."""
        model, mTb = self._model, state.mTb
        space, touch = self._space(mTb, surroundings), goal.hand_may_touch
        if goal.straight:
            line, is_whole = self._straight(state, goal)
            if is_whole and self._all_free(line, space.test(state.q, hand_may_touch=touch)):
                return self._along(line, goal.speed)
        postures = postures_at(model, self._bank, mTb, goal.target, state.q)
        path = self._first(
            state.q, postures, lambda q: space.test(state.q, q, hand_may_touch=touch)
        )
        return self._along(path, goal.speed)

    def towards(
        self, state: KinematicState, goal: PoseGoal[MapPose], surroundings: Surroundings
    ) -> Trajectory | None:
        """The hand straight towards a pose, as far as it gets; None if it cannot set out."""
        space = self._space(state.mTb, surroundings)
        is_free = space.test(state.q, hand_may_touch=goal.hand_may_touch)
        line, _ = self._straight(state, goal)
        steps = takewhile(lambda step: self._all_free(np.array(step), is_free), pairwise(line))
        part = np.array([line[0], *(end for _, end in steps)])
        return self._along(part, goal.speed) if len(part) > 1 else None

    def _straight(self, state: KinematicState, goal: PoseGoal[MapPose]) -> tuple[Array, bool]:
        settings = self._settings
        step, jump = settings.straight_step, settings.straight_jump
        return straight_postures(self._model, state.mTb, goal.target, state.q, step, jump)

    def _first(
        self, start: Array, goals: Iterable[Array], test_for: Callable[[Array], _IsFree]
    ) -> Array | None:
        """The path (M, j) to the first of some postures that is free and has one."""
        settings, limits, tried = self._settings, self._model.limits, 0
        for goal in goals:
            is_free = test_for(goal)
            if not is_free(goal):
                continue
            if self._all_free(np.array([start, goal]), is_free):
                return np.array([start, goal])
            self._seed += 1
            turn = 2.0 * np.pi
            low, high = np.minimum(start, goal) - turn, np.maximum(start, goal) + turn
            path = rrt_connect(
                start,
                goal,
                (np.maximum(limits.q_min, low), np.minimum(limits.q_max, high)),
                is_free,
                seed=self._seed,
                checks=settings.checks,
                shortcuts=settings.shortcuts,
                resolution=settings.resolution,
            )
            tried += 1
            if path is not None or tried == settings.candidates:
                return path
        return None

    def _all_free(self, path: Array, is_free: _IsFree) -> bool:
        """Whether straight lines through postures (M, j) are free."""
        for a, b in pairwise(path):
            count = max(1, int(np.ceil(float(np.linalg.norm(b - a)) / self._settings.resolution)))
            if not all(is_free(a + (b - a) * step / count) for step in range(1, count + 1)):
                return False
        return True

    def _space(self, mTb: MapPose, surroundings: Surroundings) -> _ArmSpace:
        model = self._models.around(surroundings)
        model.place(mTb, self._model.description.arm.ready, [o.geom for o in surroundings.moving])
        return _ArmSpace(model, mTb, self._settings.clearance, self._settings.close_clearance)

    def _along(self, path: Array | None, speed: float) -> Trajectory | None:
        if path is None:
            return None
        settings = self._settings
        return timed(
            self._model,
            path,
            self._period,
            speed=speed,
            speed_share=settings.speed_share,
            acceleration_share=settings.acceleration_share,
        )


class _ArmSpace:
    """The free postures of one arm among obstacles.

    The arm keeps a clearance, or a close one where the hand may touch obstacles [m].
    """

    def __init__(
        self, collision: CollisionModel, mTb: MapPose, clearance: float, close: float
    ) -> None:
        self._collision = collision
        self._mTb = mTb
        self._clearance = clearance
        self._close = close
        kinds = collision.pairs.kind
        self._pairs = np.flatnonzero(np.isin(kinds, _OF_THE_ARM))
        self._of_the_hand = kinds[self._pairs] == PairKind.HAND

    def test(self, start: Array, goal: Array | None = None, *, hand_may_touch: bool) -> _IsFree:
        """The test for postures between start (j,) and goal (j,).

        Pairs that start nearer than the clearance may stay as near, or no motion could begin. A
        hand that may touch obstacles may come as near as at the goal, or without one to contact.
        """
        clearance = self._close if hand_may_touch else self._clearance
        margins = np.minimum(clearance, self._distances(start) - _SLACK)
        pairs = self._pairs
        if hand_may_touch and goal is None:
            pairs, margins = pairs[~self._of_the_hand], margins[~self._of_the_hand]
        elif hand_may_touch and goal is not None:
            there = np.minimum(margins, self._distances(goal) - _SLACK)
            margins = np.where(self._of_the_hand, there, margins)
        touches = self._collision.contact_test(self._mTb, pairs, margins)
        return lambda q: not touches(q)

    def _distances(self, q: Array) -> Array:
        """(P,) of the pairs at a posture [m]."""
        self._collision.place(self._mTb, q)
        return self._collision.measure(self._pairs.tolist())


_METRES_PER_TILT = 0.3  # distance equivalent to the cosine of a tilt between postures [m]
_SEEDS = 60  # number of postures of the bank that the solver starts from
_SAME = 0.05  # largest joint difference of postures that count as the same [rad]


def postures_at(
    model: RobotModel, bank: PostureBank, mTb: MapPose, mTe: MapPose, q: Array
) -> Array:
    """Postures (N, j) with the end effector at `mTe`, the nearest to q (j,) first; N may be 0."""
    bTe, swivel = mTb.actInv(mTe), bank.swivel
    foot = model.description.bTa.translation if swivel is None else swivel.pivot
    away = bTe.translation - foot
    tools = bank.tools
    theirs = tools.positions - foot
    reach = np.hypot(theirs[:, 0], theirs[:, 1]) - np.hypot(away[0], away[1])
    tilt = 1.0 - tools.rotations[:, 2] @ bTe.rotation[2]
    apart = np.abs(reach) + np.abs(theirs[:, 2] - away[2]) + _METRES_PER_TILT * tilt
    seeds = np.argpartition(apart, _SEEDS)[:_SEEDS]
    postures = bank.q[seeds]
    turn = np.arctan2(away[1], away[0]) - np.arctan2(theirs[seeds, 1], theirs[seeds, 0])
    if swivel is not None:
        turned = postures[:, swivel.joint] + swivel.sign * turn
        postures[:, swivel.joint] = wrap(turned)
    postures = unwound(model, postures, q)
    found = _solved(model, mTb, mTe, np.vstack([q, postures]))
    found = found[np.argsort(np.abs(found - q).max(axis=1))]
    kept: list[Array] = []
    for one in found:
        if all(np.abs(one - other).max() > _SAME for other in kept):
            kept.append(one)
    return np.array(kept).reshape(-1, len(q))


def straight_postures(
    model: RobotModel, mTb: MapPose, mTe: MapPose, q: Array, step: float, jump: float
) -> tuple[Array, bool]:
    """Postures (M, j) from q (j,) on the straight line of the hand to `mTe`; if they get there.

    `step` [m] and `jump` [rad] are the largest distance of the hand and the largest joint
    difference between two of them.
    """
    here = model.end_effector(mTb, q)
    turn = pin.log3(here.actInv(mTe).rotation)
    distance = float(np.linalg.norm(mTe.translation - here.translation))
    count = max(2, int(np.ceil(max(distance, 0.3 * float(np.linalg.norm(turn))) / step)))
    path = [q]
    for share in np.arange(1, count + 1) / count:
        between = here.translation + share * (mTe.translation - here.translation)
        pose = SE3(here.rotation @ pin.exp3(share * turn), between)
        found = _solved(model, mTb, pose, path[-1][None])
        if not len(found) or np.abs(found[0] - path[-1]).max() > jump:
            return np.array(path), False
        path.append(found[0])
    return np.array(path), True


def _solved(model: RobotModel, mTb: MapPose, mTe: MapPose, seeds: Array) -> Array:
    """The postures that the solver finds from postures (N, j)."""
    base = np.tile(np.array(Pose2D.of(mTb)), (len(seeds), 1))
    found, errors = refine_standing(model, mTe, seeds, base)
    return found[errors <= REACHED]
