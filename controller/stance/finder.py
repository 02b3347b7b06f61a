"""Finds stances for goals among obstacles, and says why a goal cannot be reached."""

from functools import lru_cache

from pinocchio import SE3

from config.planar import ORIGIN, Pose2D
from config.poses import MapPose
from controller.collision.collision_model import CollisionModels
from controller.collision.self_collision import SelfCollision
from controller.command import Array, PoseGoal
from controller.floor.floor_map import FloorMap
from controller.model import RobotModel
from controller.stance.free_space import FreeSpace, group_names
from controller.stance.posture_bank import bank
from controller.stance.reach import REACHED, beyond_reach, out_of_reach, reach_postures
from controller.stance.search import StanceSearch
from controller.stance.stance import Stance
from controller.surroundings import OPEN_FLOOR, Surroundings
from robots import Geom, RobotDescription

_BESIDE = 0.06  # largest distance to the base of obstacles that are named where it cannot stand [m]
_FAR = 0.25  # error of a straight motion that is out of reach: it goes as far as it gets [m + rad]
_UNREACHED = 0.02  # least error of a search that reaches nothing [m + rad]
_INSIDE = 0.01  # penetration of a hand from which it is inside an obstacle [m] ...
_INSIDE_STRAIGHT = 0.03  # ... and for straight motion: its shapes reach beyond the finger tips [m]
_SPOKEN = {"held": "what the hand holds"}


class StanceFinder:
    """Judges goals, starts searches, and caches what is computed from the surroundings."""

    def __init__(
        self, model: RobotModel, collision: SelfCollision, models: CollisionModels
    ) -> None:
        self._model = model
        self._models = models
        self._collision = collision
        self._bank = bank(model.description)
        reach_postures(model.description)  # cached here, not in the first period
        self._surroundings = OPEN_FLOOR
        self.floor = FloorMap((), model.description)  # map of the static obstacles
        self.space: FreeSpace | None = None  # static obstacles in 3D; None on an open floor
        self._base: tuple[FloorMap, Pose2D, str] = self.floor, ORIGIN, ""
        """A base pose, and why it cannot stand there."""

    def update(self, surroundings: Surroundings) -> bool:
        """Take the present surroundings; whether the fixtures have changed."""
        before, self._surroundings = self._surroundings, surroundings
        fixtures, held = surroundings.fixtures, surroundings.held
        moved = fixtures is not before.fixtures
        self.update_map(fixtures)
        if moved or held is not before.held:
            around = self._models.around(surroundings) if fixtures else None
            self.space = FreeSpace(self._model, self.floor, around) if around else None
        return moved

    def update_map(self, fixtures: tuple[Geom, ...]) -> None:
        """Make the floor map of new fixtures, which takes some milliseconds."""
        if fixtures is not self.floor.fixtures:
            self.floor = FloorMap(fixtures, self._model.description)

    def obstacle_to(self, goal: PoseGoal[MapPose], mTb: Pose2D) -> str:
        """Why a goal is out of reach for every base pose; empty if it is not.

        Of a base that stands still only `mTb`, where it is, counts.
        """
        height = float(goal.target.translation[2])
        if height < -_INSIDE - goal.position_tolerance:
            return f"{-height:.2f} m below the floor"
        least = _FAR if goal.straight else REACHED
        if reason := out_of_reach(self._model.description, goal.target, least, mTb):
            return reason
        if self.space is None or goal.hand_may_touch:
            return ""
        hand = self.space.hand_at(goal.target)
        if hand.distance > -(_INSIDE_STRAIGHT if goal.straight else _INSIDE):
            return ""
        if fixture := self.space.around(goal.target.translation):
            return f"inside {fixture}"
        part = _SPOKEN.get(hand.part, f"the {hand.part}")
        return f"{part} would be inside {hand.fixture}"

    def obstacle_to_base(self, base: Pose2D) -> str:
        """Why the base cannot stand at a pose; empty if it can."""
        if (self.floor, base) != self._base[:2]:
            why = ""
            if self.space is not None and self.floor.stands_free(base)[0] <= 0.0:
                names = group_names(self.space.blocking(base, _BESIDE))
                why = f"the base would stand in {names}"
            self._base = self.floor, base, why
        return self._base[2]

    def search(
        self,
        mTe: MapPose,
        mTb: Pose2D,
        q: Array,
        failed: tuple[Stance, ...] = (),
        next_goal: SE3 | None = None,
        *,
        in_front: bool = False,
    ) -> StanceSearch:
        """A new search for a stance; see `StanceSearch`."""
        where = self._model, self._bank, self._collision, mTe, mTb, q, failed, self.space
        return StanceSearch(*where, next_goal, in_front=in_front)

    def why_none(self, search: StanceSearch) -> str:
        """Why a finished search has found no stance; empty if it has found one."""
        if search.best is not None:
            return beyond_reach(search.mTe) if search.error > _UNREACHED else ""
        if search.base_stands and not search.base_gets_there:
            return "no way for the base"
        return f"no stance stands free of {search.blocked or 'the arm itself'}"


def why_no_stance(
    robot: RobotDescription,
    mTe: MapPose,
    fixtures: tuple[Geom, ...],
    *,
    hand_may_touch: bool = False,
) -> str:
    """Why no stance reaches a pose among fixtures, from the origin of the world; empty if one does.

    What the controller says at the start of a run, as to a goal for which it may take any way.
    """
    finder, known = _among(robot, fixtures)
    asked = mTe.homogeneous.tobytes(), hand_may_touch
    if asked not in known:
        goal = PoseGoal(target=mTe, hand_may_touch=hand_may_touch)
        reason = finder.obstacle_to(goal, ORIGIN)
        if not reason:
            search = stance_search(robot, mTe, fixtures)
            search.finish()
            reason = finder.why_none(search)
        known[asked] = reason
    return known[asked]


def stance_search(
    robot: RobotDescription, mTe: MapPose, fixtures: tuple[Geom, ...]
) -> StanceSearch:
    """The search for a stance among fixtures, from the origin of the world, not begun yet."""
    return _among(robot, fixtures)[0].search(mTe, ORIGIN, robot.arm.ready)


@lru_cache(maxsize=2)
def _among(
    robot: RobotDescription, fixtures: tuple[Geom, ...]
) -> tuple[StanceFinder, dict[tuple[bytes, bool], str]]:
    """The finder among fixtures, and what it has told."""
    model = RobotModel(robot)
    finder = StanceFinder(model, SelfCollision(model), CollisionModels(model))
    finder.update(Surroundings(fixtures=fixtures))
    return finder, {}
