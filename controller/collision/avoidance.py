"""Collision avoidance: from the surroundings to constraints of the QP."""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np

from controller.collision.collision_model import CollisionModels, PairKind
from controller.collision.distance_constraints import DistanceConstraints
from controller.collision.moving_obstacles import MovingObstacleAvoidance
from controller.collision.proximity import Proximity
from controller.command import Array, KinematicState, MotionGoal, PoseGoal
from controller.floor.base_drive import Pose2D
from controller.floor.floor_map import FloorMap
from controller.model import RobotModel
from controller.qp_solver import Rows
from controller.settings import CollisionSettings, ControllerSettings
from controller.surroundings import Obstacle, Surroundings


class NearestPair(NamedTuple):
    """The pair of shapes with the smallest distance, the robot's own pairs left out."""

    pairs: int = 0  # number of all near pairs
    clearance: float = inf
    name: str = ""
    points: tuple[Array, Array] | None = None  # the nearest points (3,) of the two in the world


class CollisionAvoidance:
    """Constraints of the distances of now, and of the predicted motion of moving obstacles."""

    def __init__(
        self,
        model: RobotModel,
        settings: ControllerSettings,
        collision: CollisionSettings,
        models: CollisionModels,
    ) -> None:
        self._constraints = DistanceConstraints(model, settings, collision)
        self._proximity = Proximity(model, self._constraints.ranges, models)
        self._moving_obstacles = MovingObstacleAvoidance(model)

    def prepare(self, surroundings: Surroundings) -> None:
        """Compute in advance what the first period in these surroundings needs."""
        self._proximity.update_shapes(surroundings)

    def update(self, applied: Array) -> None:
        """Note the velocities (n,) that were applied in the last period."""
        self._constraints.update(applied)

    def rows(
        self,
        state: KinematicState,
        base: Pose2D,
        goal: MotionGoal | None,
        bounds: tuple[Array, Array],
        surroundings: Surroundings,
    ) -> tuple[Rows | None, NearestPair]:
        """The distance constraints that can bind within the velocity bounds (n,)."""
        fastest = np.maximum(-bounds[0], bounds[1])
        near = self._proximity.near(state.wTb, state.q, surroundings, fastest, base)
        if isinstance(goal, PoseGoal) and goal.hand_may_touch:
            near = near.without(PairKind.HAND)
        if not len(near.d):
            return None, NearestPair()
        to_obstacles = np.where(near.kind == PairKind.SELF, inf, near.d)
        first = int(to_obstacles.argmin())
        clearance = float(to_obstacles[first])
        rows = self._constraints.rows(near, bounds, goal)
        if clearance == inf:
            return rows, NearestPair(len(near.d))
        pair = int(near.pair[first])
        name, points = self._proximity.pair_name(pair), self._proximity.pair_points(pair)
        return rows, NearestPair(len(near.d), clearance, name, points)

    def give_way(
        self,
        base: Pose2D,
        q: Array,
        wanted: Array,
        led: Array | None,
        moving: tuple[Obstacle, ...],
        floor: FloorMap | None,
        bounds: tuple[Array, Array],
    ) -> Rows | None:
        """The rows that give way to moving obstacles; see `MovingObstacleAvoidance.rows`."""
        now = self._constraints.velocities
        return self._moving_obstacles.rows(base, q, now, wanted, led, moving, floor, bounds)
