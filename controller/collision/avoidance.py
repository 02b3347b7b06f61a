"""What keeps the robot off itself, the floor and everything around, as rows of the QP."""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np

from controller.collision.collision_model import CollisionModels, PairKind
from controller.collision.distance_constraints import DistanceConstraints
from controller.collision.moving_obstacles import MovingObstacleAvoidance
from controller.collision.proximity import Proximity
from controller.command import Array, KinematicState, MotionGoal, PoseGoal
from controller.floor import FloorMap, Pose2D
from controller.model import RobotModel
from controller.qp_solver import Rows
from controller.settings import CollisionSettings, ControllerSettings
from controller.surroundings import Obstacle, Surroundings


class NearestPair(NamedTuple):
    """What is near the robot."""

    pairs: int = 0
    clearance: float = inf
    name: str = ""
    """Of what is nearest, and what it is nearest to."""
    points: tuple[Array, Array] | None = None
    """Where those two are nearest to each other, in the world."""


class CollisionAvoidance:
    """Distances, how fast they may shrink, and giving way to what moves.

    Args:
        model: the robot.
        settings: of the controller.
        collision: when, and how strongly.
        models: of the robot among what stands around.
    """

    def __init__(
        self,
        model: RobotModel,
        settings: ControllerSettings,
        collision: CollisionSettings,
        models: CollisionModels,
    ) -> None:
        self._dampers = DistanceConstraints(model, settings, collision)
        self._proximity = Proximity(model, self._dampers.ranges, models)
        self._yielding = MovingObstacleAvoidance(model)

    def prepare(self, surroundings: Surroundings) -> None:
        """Compute now what the first period in surroundings needs."""
        self._proximity.heed(surroundings)

    def follow(self, applied: Array) -> None:
        """Note what was applied in the last period, (n,)."""
        self._dampers.follow(applied)

    def rows(
        self,
        state: KinematicState,
        here: Pose2D,
        goal: MotionGoal | None,
        bounds: tuple[Array, Array],
        surroundings: Surroundings,
    ) -> tuple[Rows | None, NearestPair]:
        """The distance rows that can bind in this period, and what is near.

        Args:
            state: where base and arm are.
            here: the base on the floor.
            goal: says what the hand may touch, and how near the robot may come.
            bounds: lower and upper bounds (n,) of the velocities.
            surroundings: what must not be hit.
        """
        fastest = np.maximum(-bounds[0], bounds[1])
        near = self._proximity.near(state.wTb, state.q, surroundings, fastest, here)
        if isinstance(goal, PoseGoal) and goal.hand_may_touch:
            near = near.without(PairKind.HAND)
        if not len(near.d):
            return None, NearestPair()
        away = np.where(near.kind == PairKind.SELF, inf, near.d)
        first = int(away.argmin())
        clearance = float(away[first])
        rows = self._dampers.rows(near, bounds, goal)
        if clearance == inf:
            return rows, NearestPair(len(near.d))
        pair = int(near.pair[first])
        name, points = self._proximity.pair_name(pair), self._proximity.pair_points(pair)
        return rows, NearestPair(len(near.d), clearance, name, points)

    def give_way(
        self,
        here: Pose2D,
        q: Array,
        wanted: Array,
        led: Array | None,
        moving: tuple[Obstacle, ...],
        floor: FloorMap | None,
        bounds: tuple[Array, Array],
    ) -> Rows | None:
        """The rows that give way to what moves; see `MovingObstacleAvoidance.rows`."""
        now = self._dampers.velocities
        return self._yielding.rows(here, q, now, wanted, led, moving, floor, bounds)
