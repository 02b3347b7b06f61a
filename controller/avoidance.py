"""What keeps the robot off itself, the floor and what stands around."""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np

from controller.base_drive import Pose2D
from controller.collision_model import CollisionModels, PairKind
from controller.command import Array, KinematicState, MotionGoal, PoseGoal
from controller.dampers import Dampers
from controller.model import RobotModel
from controller.proximity import Proximity
from controller.qp import Rows
from controller.settings import CollisionSettings, ControllerSettings
from controller.surroundings import Surroundings


class Near(NamedTuple):
    """What is near the robot."""

    pairs: int = 0
    """Of shapes, the robot with itself among them."""
    clearance: float = inf
    """Distance to what is nearest around it [m]."""
    name: str = ""
    """Of what comes nearest to what; empty if nothing is near."""


class Avoidance:
    """Measures what is near, and makes rows of it, from period to period.

    Args:
        model: the robot.
        settings: of the controller.
        collision: those of distances.
        models: where collision models are made.
    """

    def __init__(
        self,
        model: RobotModel,
        settings: ControllerSettings,
        collision: CollisionSettings,
        models: CollisionModels,
    ) -> None:
        self._dampers = Dampers(model, settings, collision)
        self._proximity = Proximity(model, self._dampers.ranges, models)

    @property
    def velocities(self) -> Array:
        """(n,) that base and arm have now, as far as their lags tell."""
        return self._dampers.velocities

    def prepare(self, surroundings: Surroundings) -> None:
        """Compute now what the first step in surroundings needs."""
        self._proximity.heed(surroundings)

    def rows(
        self,
        state: KinematicState,
        here: Pose2D,
        goal: MotionGoal | None,
        applied: Array,
        bounds: tuple[Array, Array],
        surroundings: Surroundings,
    ) -> tuple[Rows | None, Near]:
        """The rows that can bind, if any, and what is near.

        A robot without a goal comes to rest: it only brakes.

        Args:
            state: where base and arm are.
            here: the base on the floor.
            goal: where to go; says how near it may come to what.
            applied: (n,) velocities of the previous period.
            bounds: lower and upper bounds (n,) of the velocities.
            surroundings: what must not be hit.
        """
        self._dampers.follow(applied)
        if goal is None:
            return None, Near()
        fastest = np.maximum(-bounds[0], bounds[1])
        near = self._proximity.near(state.wTb, state.q, surroundings, fastest, here)
        straight = isinstance(goal, PoseGoal) and goal.straight
        if isinstance(goal, PoseGoal) and goal.hand_may_touch:
            near = near.without(PairKind.HAND)
        if not len(near.d):
            return None, Near()
        away = np.where(near.kind == PairKind.SELF, inf, near.d)
        first = int(away.argmin())
        clearance = float(away[first])
        name = self._proximity.pair_name(int(near.pair[first])) if clearance < inf else ""
        rows = self._dampers.rows(near, bounds, straight=straight)
        return rows, Near(len(near.d), clearance, name)
