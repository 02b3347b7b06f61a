"""Where and how a robot can stand for a goal in its surroundings, and why it cannot."""

from __future__ import annotations

import numpy as np
from pinocchio import SE3

from controller.collision import CollisionModels, SelfCollision
from controller.command import Array, PoseGoal
from controller.floor import FloorMap, Pose2D
from controller.model import RobotModel
from controller.stance.free_space import FreeSpace, group_names
from controller.stance.posture_bank import bank
from controller.stance.reachability import obstacle_to, why_no_stance
from controller.stance.search import StanceSearch
from controller.stance.stance import Stance
from controller.stance_settings import StanceSettings
from controller.surroundings import OPEN_FLOOR, Surroundings
from robots import Geom

_BESIDE = 0.06
"""What is nearer to the base than this is named where it cannot stand [m]."""


class StanceFinder:
    """Judges goals and starts searches, and keeps what is computed once from the surroundings.

    Args:
        model: the robot.
        settings: what a stance costs.
        collision: the robot's own shapes.
        models: where those of robot and surroundings are made.
    """

    def __init__(
        self,
        model: RobotModel,
        settings: StanceSettings,
        collision: SelfCollision,
        models: CollisionModels,
    ) -> None:
        self._model = model
        self._models = models
        self._settings = settings
        self._collision = collision
        self._bank = bank(model.description)
        self._surroundings = OPEN_FLOOR
        self.floor = FloorMap((), model.description)
        """What stands around, seen from above."""
        self.space: FreeSpace | None = None
        """What stands around, in full; None on an open floor."""

    def meet(self, surroundings: Surroundings) -> bool:
        """Take note of what stands around; whether it is not what stood around before."""
        before, self._surroundings = self._surroundings, surroundings
        fixtures, held = surroundings.fixtures, surroundings.held
        moved = fixtures is not before.fixtures
        self.map(fixtures)
        if moved or held is not before.held:
            models = self._models
            self.space = (
                FreeSpace(self._model, self.floor, models.around(surroundings))
                if fixtures
                else None
            )
        return moved

    def map(self, fixtures: tuple[Geom, ...]) -> None:
        """See fixtures from above, unless that was done; it takes some milliseconds."""
        if fixtures is not self.floor.fixtures:
            self.floor = FloorMap(fixtures, self._model.description)

    def obstacle_to(self, goal: PoseGoal) -> str:
        """What is wrong with a goal wherever the robot stands; empty if nothing is."""
        return obstacle_to(goal, self._bank, self.space)

    def obstacle_to_base(self, base: Pose2D) -> str:
        """What stands where the base is to be; empty if nothing does."""
        if self.space is None or self.floor.stands_free(np.array([base]))[0] > 0.0:
            return ""
        return f"the base would stand in {group_names(self.space.blocking(base, _BESIDE))}"

    def search(
        self,
        wTe: SE3,
        wTb: Pose2D,
        q: Array,
        failed: tuple[Stance, ...] = (),
        onward: SE3 | None = None,
        *,
        in_front: bool = False,
    ) -> StanceSearch:
        """A new search for a stance; see there."""
        model, settings, bank, collision = self._model, self._settings, self._bank, self._collision
        where = model, settings, bank, collision, wTe, wTb, q, failed, self.space, onward
        return StanceSearch(*where, in_front=in_front)

    def why_none(self, search: StanceSearch) -> str:
        """Why a search that is over has found no stance; empty if what it has found will do."""
        return why_no_stance(search, self._bank)
