"""The search for a stance, a bounded piece of it in every control period.

The bank's postures near the goal's height and tilt are ranked by cost, the best are refined by
inverse kinematics, and the best of those is taken that stands free and whose arm moves there
without contact.
"""

from collections.abc import Generator, Iterator
from math import inf, pi

import numpy as np
from pinocchio import SE3

from config.arrays import Array, Mask
from config.planar import Pose2D, wrap
from config.poses import MapPose
from controller.collision.self_collision import SelfCollision
from controller.floor.cost_field import CostField
from controller.floor.floor_map import FloorMap
from controller.model import RobotModel
from controller.stance.dexterity import dexterity, stance_margins
from controller.stance.docking import with_docking
from controller.stance.free_space import FreeSpace, group_names, se3_of
from controller.stance.posture_bank import Candidates, PostureBank, candidates, sideways
from controller.stance.stance import (
    REACHED,
    Stance,
    base_poses,
    refine,
    refine_standing,
    unwound,
)
from controller.stance.stance_cost import Start, missing_clearance, stance_costs
from controller.stance.tool_poses import ToolPoses, forward_kinematics

RANKED = 400  # number of postures ranked in one piece of work on an open floor ...
RANKED_AMONG_FIXTURES = 200  # ... and among fixtures
BATCH = 12  # number of postures refined in one piece, the best first
CHECKS = 6
"""Number of postures checked for contact in one piece; the last may be followed by the check of its
motion, ..."""
MOTION_CHECKS, MOTION_CHECKS_AMONG_FIXTURES = 3, 6  # ... which counts as this many
_MAX_BATCHES = 3  # number of batches that are refined in one window

_CLEARANCE = 0.02  # distance to obstacles that the arm keeps on its motion, and there [m]
_STANDING_ROOM = 0.05  # distance to obstacles that the base keeps [m]
_CONTACT_COST = 1000.0  # cost per missing clearance [s/m]
_UNREACHED_COST = 100.0  # cost of a posture with errors, and again per metre and radian of them [s]
_FAILED_COST = 50.0  # cost of a posture that stalled before [s]; a cheaper stance ends the search
_JOINT_DIFFERENCE = 0.7  # largest joint difference of postures that count as the same [rad]

_ANGLES = np.linspace(0.0, 2.0 * pi, 12, endpoint=False)
_RING = 0.5 * np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
"""Places around the base [m]; without a path to any of them the cost field is not used."""
_MAX_NAMED = 6  # largest number of bases whose obstacles are named


class StanceSearch:
    """Looks for the stance that reaches a pose soonest, among those that are dexterous and free.

    `mTe` is the pose to reach, `q` are (j,) joint positions [rad]; `failed` are stances that
    stalled before this goal, another one is preferred; `space` are static obstacles, None on an
    open floor; `in_front` is whether the base must have the goal in front, as to follow it.
    """

    def __init__(
        self,
        model: RobotModel,
        bank: PostureBank,
        collision: SelfCollision,
        mTe: MapPose,
        mTb: Pose2D,
        q: Array,
        failed: tuple[Stance, ...] = (),
        space: FreeSpace | None = None,
        next_goal: SE3 | None = None,
        *,
        in_front: bool = False,
    ) -> None:
        self._model = model
        self._bank = bank
        self._collision = collision
        self.mTe = mTe  # the pose to reach
        self._sideways = 1.0 if in_front else sideways(mTe)
        self._failed = failed
        self._space = space
        self._start = Start(mTb, q.copy())
        self._next_goal = next_goal
        self.best: Stance | None = None  # the best stance so far, if there is one
        self.error = inf  # least error of any posture [m + rad]
        self.blocked = ""  # names of the obstacles that block the stances
        self.base_stands = self.base_gets_there = False
        """Whether the base stands free in any stance, and whether there is a path to one."""
        self.chosen = False  # whether `best` is final except for its dock
        self.done = False  # whether the search is over
        self._cost = inf
        self._in_the_way: list[str] = []
        self._occupied: list[Pose2D] = []
        self._work = self._pieces()

    def advance(self) -> None:
        """Do one bounded piece of work."""
        self.done = self.done or next(self._work, "over") == "over"

    def finish(self) -> Stance | None:
        """Do all the work at once."""
        while not self.done:
            self.advance()
        return self.best

    def _pieces(self) -> Iterator[None]:
        """The whole search, a piece of bounded work before every `yield`."""
        space = self._space
        if space is not None:
            self._start = self._start._replace(
                floor=space.floor, way=self._way(space.floor, self._start.mTb[:2])
            )
            yield
        if self._next_goal is not None:
            x, y, _ = self._next_goal.translation.tolist()
            way = CostField(None, (x, y)) if space is None else self._way(space.floor, (x, y))
            self._start = self._start._replace(next_goal=way)
            yield
        yield from self._look()
        if space is None:
            return
        yield
        if self.best is not None:
            self.chosen = True
            base = self.best.base_for(self.mTe)
            self.best = yield from with_docking(self._model, space, base, self.best)
            return
        blocking = (space.blocking(base, _STANDING_ROOM) for base in self._occupied)
        names = [name for some in blocking for name in some]
        self.blocked = group_names([*self._in_the_way, *names])

    def _look(self) -> Iterator[None]:
        """Find the best stance, one window after the other until it is good enough."""
        among_fixtures = self._space is not None
        has_choice = dexterity(self._model.description).has_choice
        for some in candidates(
            self._bank, self.mTe, among_fixtures=among_fixtures, has_choice=has_choice
        ):
            ranked = yield from self._rank(some)
            for first in range(0, min(len(ranked[0]), _MAX_BATCHES * BATCH), BATCH):
                yield
                postures, errors = self._refine(*(each[first : first + BATCH] for each in ranked))
                self.error = min(self.error, float(errors.min()))
                yield
                yield from self._judge(postures, errors)
                if self._cost < _FAILED_COST:
                    return

    def _way(self, floor: FloorMap, goal: tuple[float, float]) -> CostField | None:
        """The cost to drive to x, y [m]; None if there is no path from around the base."""
        x, y, _ = self._start.mTb
        way = floor.field(goal)
        return way if np.isfinite(way.at(np.array([x, y]) + _RING)).any() else None

    def _rank(self, some: Candidates) -> Generator[None, None, tuple[Array, Array]]:
        """Postures (N, j) and free bases (N, 3) with a path there, the cheapest first."""
        swivel, limits = self._bank.swivel, self._model.limits
        postures = self._bank.q[some.indices]
        if swivel is not None:
            postures[:, swivel.joint] += swivel.sign * some.turns
        postures = unwound(self._model, postures, self._start.q)
        costs, bases = np.empty(len(postures)), np.empty((len(postures), 3))
        count = RANKED if self._space is None else RANKED_AMONG_FIXTURES
        for first in range(0, len(postures), count):
            if first:
                yield
            piece = slice(first, first + count)
            tools = ToolPoses(*(values[some.indices[piece]] for values in self._bank.tools))
            if swivel is not None:
                tools = tools.turned(swivel, some.turns[piece])
            costs[piece], bases[piece], _ = self._costs(postures[piece], tools)
        if swivel is not None:
            joint, margins = swivel.joint, stance_margins(self._model.description)
            low, high = (limits.q_min + margins)[joint], (limits.q_max - margins)[joint]
            costs[(postures[:, joint] < low) | (postures[:, joint] > high)] = inf
        order = np.argsort(costs)
        order = order[: np.searchsorted(costs[order], inf)]
        return postures[order], bases[order]

    def _refine(self, postures: Array, bases: Array) -> tuple[Array, Array]:
        """Postures (N, j) that reach the goal, and their errors (N,) [m + rad]."""
        here, swivel = self._start.mTb, self._bank.swivel
        if self._model.description.stands_still:
            if swivel is not None:  # the arm turns instead of the base
                turns = wrap(bases[:, 2] - here.heading)
                postures[:, swivel.joint] += swivel.sign * turns
            bases = np.tile(here, (len(postures), 1))
            postures = refine_standing(self._model, self.mTe, postures, bases)[0]
        elif self._space is None or not dexterity(self._model.description).has_choice:
            return refine(self._model, self.mTe, postures)
        return refine_standing(self._model, self.mTe, postures, bases)

    def _costs(self, postures: Array, tools: ToolPoses) -> tuple[Array, Array, Mask]:
        """Costs (N,) [s], infinite if not free; base poses (N, 3); whether backwards (N,)."""
        bases = base_poses(self.mTe, tools)
        costs, reverse = stance_costs(
            self._model, self._start, bases, postures, tools, self._sideways
        )
        if self._space is not None:
            free = self._space.floor.stands_free(bases) >= _STANDING_ROOM
            self.base_stands = self.base_stands or bool(free.any())
            self.base_gets_there = self.base_gets_there or bool(np.isfinite(costs[free]).any())
            if len(self._occupied) < _MAX_NAMED:
                self._occupied += [Pose2D(*base) for base in bases[~free][:2].tolist()]
            costs = np.where(free, costs, inf)
        return costs, bases, reverse

    def _judge(self, postures: Array, errors: Array) -> Iterator[None]:
        """Keep the best of postures (N, j) with errors (N,), if it is the best so far."""
        tools = forward_kinematics(self._model.description, postures)
        costs, bases, reverse = self._costs(postures, tools)
        unreached = _UNREACHED_COST if self._space is None else inf
        costs = np.where(errors > REACHED, costs + unreached * (1.0 + errors), costs)
        for stance in self._failed:
            same = np.abs(postures - stance.q).max(axis=1) < _JOINT_DIFFERENCE
            costs = costs + np.where(same, _FAILED_COST, 0.0)
        if self._space is not None:
            yield
        checks = 0
        for one in np.argsort(costs):
            cost, base = float(costs[one]), Pose2D(*bases[one].tolist())
            if cost >= self._cost:
                return
            if checks >= CHECKS:
                yield
                checks = 0
            checks += 1
            if not self._arm_is_free(base, postures[one]):
                continue
            checks += MOTION_CHECKS if self._space is None else MOTION_CHECKS_AMONG_FIXTURES
            bTe = SE3(tools.rotations[one], tools.positions[one])
            stance = Stance(postures[one], bTe, bool(reverse[one]))
            missing = missing_clearance(
                self._collision, self._space, self._start, base, stance, _CLEARANCE
            )
            cost += _CONTACT_COST * missing
            if cost < self._cost:
                self._cost, self.best = cost, stance

    def _arm_is_free(self, base: Pose2D, posture: Array) -> bool:
        """Whether the arm without its hand, which the goal places, stands free of fixtures."""
        if self._space is None:
            return True
        near = self._space.nearest(se3_of(base), posture, self._space.arm, _CLEARANCE)
        if near.distance < _CLEARANCE:
            self._in_the_way.append(near.fixture)
            return False
        return True
