"""Finds stances for goals among obstacles, and says why a goal cannot be reached."""

from functools import lru_cache

import numpy as np
from pinocchio import SE3

from controller.collision.collision_model import CollisionModels
from controller.collision.self_collision import SelfCollision
from controller.command import Array, PoseGoal
from controller.floor.base_drive import Pose2D
from controller.floor.floor_map import FloorMap
from controller.model import RobotModel
from controller.stance.free_space import FreeSpace, group_names
from controller.stance.posture_bank import PostureBank, bank, forward_kinematics, stored_postures
from controller.stance.search import StanceSearch
from controller.stance.stance import Stance
from controller.surroundings import OPEN_FLOOR, Surroundings
from robots import Geom, RobotDescription

_BESIDE = 0.06  # largest distance to the base of obstacles that are named where it cannot stand [m]
_SAME_TILT = 0.96  # cosine between the verticals of postures with the same tilt
_BANK_GAP = 0.25  # least distance beyond the bank's highest and lowest posture out of reach [m]
_FEW_GAP = 0.3  # the same for a quarter of the bank [m]
_UNREACHED = 0.02  # least error of the best posture for a goal that is out of reach [m + rad]
_INSIDE = 0.01  # penetration of a hand from which it is inside an obstacle [m] ...
_INSIDE_STRAIGHT = 0.03  # ... and for straight motion: its shapes reach beyond the finger tips [m]
_SPOKEN = {"link7": "the wrist", "held": "what the hand holds"}


class StanceFinder:
    """Judges goals, starts searches, and caches what is computed from the surroundings."""

    def __init__(
        self, model: RobotModel, collision: SelfCollision, models: CollisionModels
    ) -> None:
        self._model = model
        self._models = models
        self._collision = collision
        self._bank = bank(model.description)
        self._surroundings = OPEN_FLOOR
        self.floor = FloorMap((), model.description)  # map of the static obstacles
        self.space: FreeSpace | None = None  # static obstacles in 3D; None on an open floor

    def update(self, surroundings: Surroundings) -> bool:
        """Take the present surroundings; whether the fixtures have changed."""
        before, self._surroundings = self._surroundings, surroundings
        fixtures, held = surroundings.fixtures, surroundings.held
        moved = fixtures is not before.fixtures
        self.update_map(fixtures)
        if moved or held is not before.held:
            models = self._models
            self.space = (
                FreeSpace(self._model, self.floor, models.around(surroundings))
                if fixtures
                else None
            )
        return moved

    def update_map(self, fixtures: tuple[Geom, ...]) -> None:
        """Make the floor map of new fixtures, which takes some milliseconds."""
        if fixtures is not self.floor.fixtures:
            self.floor = FloorMap(fixtures, self._model.description)

    def obstacle_to(self, goal: PoseGoal) -> str:
        """Why a goal is out of reach for every base pose; empty if it is not."""
        height = float(goal.wTe.translation[2])
        if height < -_INSIDE - goal.position_tolerance:
            return f"{-height:.2f} m below the floor"
        low, high = _heights(self._bank, goal.wTe.rotation[2])
        if height > high + _BANK_GAP or height < low - _BANK_GAP:
            return _out_of_reach(height, low, high)
        if self.space is None or goal.hand_may_touch:
            return ""
        hand = self.space.hand_at(goal.wTe)
        if hand.distance > -(_INSIDE_STRAIGHT if goal.straight else _INSIDE):
            return ""
        if fixture := self.space.around(goal.wTe.translation):
            return f"inside {fixture}"
        part = _SPOKEN.get(hand.part, f"the {hand.part}")
        return f"{part} would be inside {hand.fixture}"

    def obstacle_to_base(self, base: Pose2D) -> str:
        """Why the base cannot stand at a pose; empty if it can."""
        if self.space is None or self.floor.stands_free(np.array([base]))[0] > 0.0:
            return ""
        return f"the base would stand in {group_names(self.space.blocking(base, _BESIDE))}"

    def search(
        self,
        wTe: SE3,
        wTb: Pose2D,
        q: Array,
        failed: tuple[Stance, ...] = (),
        next_goal: SE3 | None = None,
        *,
        in_front: bool = False,
    ) -> StanceSearch:
        """A new search for a stance; see `StanceSearch`."""
        where = self._model, self._bank, self._collision, wTe, wTb, q, failed, self.space
        return StanceSearch(*where, next_goal, in_front=in_front)

    def why_none(self, search: StanceSearch) -> str:
        """Why a finished search has found no stance; empty if it has found one."""
        if _UNREACHED < search.error < np.inf:
            height = float(search.wTe.translation[2])
            return _out_of_reach(height, *_heights(self._bank, search.wTe.rotation[2]))
        if search.best is not None:
            return ""
        if search.base_stands and not search.base_gets_there:
            return "no way for the base"
        return f"no stance stands free of {search.blocked}"


def out_of_reach(robot: RobotDescription, wTe: SE3) -> str:
    """Why a pose is too high or low for the hand with its tilt; empty if it is not.

    Quick, for checks before a robot moves: it looks at a quarter of the posture bank.
    """
    height, (low, high) = float(wTe.translation[2]), _heights(_few(robot), wTe.rotation[2])
    inside = low - _FEW_GAP <= height <= high + _FEW_GAP
    return "" if inside else _out_of_reach(height, low, high)


@lru_cache(maxsize=4)
def _few(robot: RobotDescription) -> PostureBank:
    q = stored_postures(robot, every=4)
    return PostureBank(q, forward_kinematics(robot, q))


def _heights(bank: PostureBank, vertical: Array) -> tuple[float, float]:
    """Least and largest height [m] of hands that see the world's vertical (3,) like this."""
    same = np.flatnonzero(bank.tools.rotations[:, 2] @ vertical > _SAME_TILT)
    if len(same) == 0:
        return np.inf, -np.inf
    heights = bank.tools.positions[same, 2]
    return float(heights.min()), float(heights.max())


def _out_of_reach(height: float, low: float, high: float) -> str:
    if height > high:
        return f"{height:.2f} m up: tilted like this the hand reaches {high:.1f} m"
    if height < low:
        return f"{height:.2f} m up: tilted like this the hand reaches down to {low:.1f} m"
    return f"{height:.2f} m up: the arm has no posture of that height and tilt"
