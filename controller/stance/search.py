"""The search for a stance, a bounded piece of it in every step of control.

The bank's postures near the goal's height and tilt are ranked by what they would cost, the best are
refined until they have exactly that height and tilt, and the best of those is taken whose base and
arm stand free and whose fold, the straight path in joint space, is clear of contact.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from math import inf, pi
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from controller.collision import SelfCollision
from controller.command import Array
from controller.floor import CostField, FloorMap, Pose2D
from controller.model import RobotModel
from controller.stance.candidates import Candidates, candidates, sideways
from controller.stance.docking import with_docking
from controller.stance.fold import room_missing
from controller.stance.free_space import ARM, FreeSpace, group_names, se3_of
from controller.stance.posture_bank import PostureBank, ToolPoses, forward_kinematics
from controller.stance.stance import (
    REACHED,
    Stance,
    base_poses,
    refine,
    refine_standing,
    stance_costs,
)
from controller.stance.stance_cost import Start
from controller.stance_settings import StanceSettings

Indices: TypeAlias = npt.NDArray[np.int64]
Mask: TypeAlias = npt.NDArray[np.bool_]

RANKED = 400
"""Postures that are ranked in one step on an open floor ..."""
RANKED_AMONG_FIXTURES = 200
"""... and among fixtures, where every one is looked up in the map."""
BATCH = 12
"""Postures that are refined in one step, the best first."""
CHECKS = 6
"""Postures that are checked for contact in one step; the last may be followed by its fold ..."""
FOLD = 3
"""... which counts as this many checks on an open floor ..."""
FOLD_AMONG_FIXTURES = 6
"""... and as this many among fixtures."""
_MAX_BATCHES = 3
"""Batches of a window that are refined before the best posture so far is taken, good enough or
not."""

_ANGLES = np.linspace(0.0, 2.0 * pi, 12, endpoint=False)
_RING = 0.5 * np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
"""Places around the base; where there is a way to none, the map says nothing about ways [m]."""
_SPOKEN_OF = 6
"""Bases that do not stand free which are looked at to say what is in the way."""


class StanceSearch:
    """Looks for the stance that reaches a pose soonest, among those that are dexterous and free.

    Args:
        model: the robot.
        settings: what a stance costs.
        bank: the postures to choose from.
        collision: the robot's shapes.
        wTe: the pose to reach.
        wTb: base pose.
        q: (7,) joint positions [rad].
        failed: stances that stalled before this goal; another one is preferred.
        space: what stands around; None on an open floor.
        onward: where the end effector goes next; None where that is not known.
        in_front: whether the base has to have it in front, as below a goal that it follows.
    """

    def __init__(
        self,
        model: RobotModel,
        settings: StanceSettings,
        bank: PostureBank,
        collision: SelfCollision,
        wTe: SE3,
        wTb: Pose2D,
        q: Array,
        failed: tuple[Stance, ...] = (),
        space: FreeSpace | None = None,
        onward: SE3 | None = None,
        *,
        in_front: bool = False,
    ) -> None:
        self._model = model
        self._settings = settings
        self._bank = bank
        self._collision = collision
        self.wTe = wTe
        """The pose to reach."""
        self._sideways = 1.0 if in_front else sideways(wTe)
        self._failed = failed
        self._space = space
        self._start = Start(wTb, q.copy())
        self._onward = onward
        self.best: Stance | None = None
        """The best stance so far; None if there is none."""
        self.error = inf
        """Least error that was left to any posture [m + rad]."""
        self.blocked = ""
        """What keeps the stances that were looked at from standing free, for people."""
        self.base_stands = self.base_gets_there = False
        """Whether the base stands free in any of them, and whether there is a way to one."""
        self.chosen = False
        """Whether `best` stays, but for where it docks."""
        self.done = False
        """Whether the search is over: `best` is good enough, or nothing better was found."""
        self._cost = inf
        self._in_the_way: list[str] = []
        self._occupied: list[Pose2D] = []
        self._work = self._pieces()

    def advance(self) -> None:
        """Do one piece of work."""
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
            self._start = self._start._replace(way=self._way(space.floor, self._start.wTb[:2]))
            yield
        if self._onward is not None:
            x, y, _ = self._onward.translation.tolist()
            way = CostField(None, (x, y)) if space is None else self._way(space.floor, (x, y))
            self._start = self._start._replace(onward=way)
            yield
        yield from self._look()
        if space is None:
            return
        yield
        if self.best is not None:
            self.chosen = True
            base = self.best.base_for(self.wTe)
            self.best = yield from with_docking(self._model, space, base, self.best)
            return
        anywhere = next(candidates(self._bank, self.wTe)).indices[:BATCH]
        postures = self._bank.q[anywhere]
        errors = refine(self._model, self._settings, self.wTe, postures)[1]
        self.error = float(errors.min())
        room = self._settings.standing_room
        names = [name for base in self._occupied for name in space.blocking(base, room)]
        self.blocked = group_names([*self._in_the_way, *names])

    def _look(self) -> Iterator[None]:
        """Find the best stance, one window after the other until it is good enough."""
        among_fixtures = self._space is not None
        for some in candidates(self._bank, self.wTe, among_fixtures=among_fixtures):
            ranked = yield from self._rank(some)
            for first in range(0, min(len(ranked[0]), _MAX_BATCHES * BATCH), BATCH):
                yield
                postures, errors = self._refine(*(each[first : first + BATCH] for each in ranked))
                self.error = min(self.error, float(errors.min()))
                yield
                yield from self._judge(postures, errors)
                if self._cost < self._settings.failed_cost:
                    return

    def _way(self, floor: FloorMap, goal: tuple[float, float]) -> CostField | None:
        """What it costs to drive from anywhere to a place x, y [m].

        None where that is not known from around the base, which may stand too near to something.
        """
        x, y, _ = self._start.wTb
        way = floor.field(goal)
        return way if np.isfinite(way.at(np.array([x, y]) + _RING)).any() else None

    def _rank(self, some: Candidates) -> Generator[None, None, tuple[Array, Array]]:
        """Postures (N, 7) and bases (N, 3) that are free, with a way there, the cheapest first."""
        foot, limit = self._model.description.bTa, self._settings.limit_margin
        limits = self._model.limits
        postures = self._bank.q[some.indices]
        postures[:, 0] += some.turns
        costs, bases = np.empty(len(postures)), np.empty((len(postures), 3))
        count = RANKED if self._space is None else RANKED_AMONG_FIXTURES
        for first in range(0, len(postures), count):
            if first:
                yield
            piece = slice(first, first + count)
            tools = ToolPoses(*(values[some.indices[piece]] for values in self._bank.tools))
            tools = tools.turned(foot, some.turns[piece])
            costs[piece], bases[piece], _ = self._costs(postures[piece], tools)
        q = postures[:, 0]
        costs[(q < limits.q_min[0] + limit) | (q > limits.q_max[0] - limit)] = inf
        order = np.argsort(costs)
        order = order[: np.searchsorted(costs[order], inf)]
        return postures[order], bases[order]

    def _refine(self, postures: Array, bases: Array) -> tuple[Array, Array]:
        """Postures (N, 7) that reach the goal, and what they lack (N,) [m + rad]."""
        model, settings, wTe = self._model, self._settings, self.wTe
        if self._space is None:
            return refine(model, settings, wTe, postures)
        return refine_standing(model, settings, wTe, postures, bases)

    def _costs(self, postures: Array, tools: ToolPoses) -> tuple[Array, Array, Mask]:
        """Costs (N,) [s], infinite if not free, base poses (N, 3), and whether it backs (N,)."""
        bases = base_poses(self.wTe, tools)
        costs, reverse = stance_costs(
            self._model, self._settings, self._start, bases, postures, tools, self._sideways
        )
        if self._space is not None:
            free = self._space.floor.stands_free(bases) >= self._settings.standing_room
            self.base_stands = self.base_stands or bool(free.any())
            self.base_gets_there = self.base_gets_there or bool(np.isfinite(costs[free]).any())
            if len(self._occupied) < _SPOKEN_OF:
                self._occupied += [Pose2D(*base) for base in bases[~free][:2].tolist()]
            costs = np.where(free, costs, inf)
        return costs, bases, reverse

    def _judge(self, postures: Array, errors: Array) -> Iterator[None]:
        """Keep the best of postures (N, 7) with these errors (N,), if it is the best so far."""
        settings = self._settings
        tools = forward_kinematics(self._model.description, postures)
        costs, bases, reverse = self._costs(postures, tools)
        unreached = settings.unreached_cost if self._space is None else inf
        costs = np.where(errors > REACHED, costs + unreached * (1.0 + errors), costs)
        for stance in self._failed:
            same = np.abs(postures - stance.q).max(axis=1) < settings.joint_difference
            costs = costs + np.where(same, settings.failed_cost, 0.0)
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
            checks += FOLD if self._space is None else FOLD_AMONG_FIXTURES
            bTe = SE3(tools.rotations[one], tools.positions[one])
            stance = Stance(postures[one], bTe, bool(reverse[one]))
            missing = room_missing(
                self._collision, self._space, self._start, base, stance, settings.clearance
            )
            cost += settings.contact_cost * missing
            if cost < self._cost:
                self._cost, self.best = cost, stance

    def _arm_is_free(self, base: Pose2D, posture: Array) -> bool:
        """Whether the arm stands free of fixtures; where the hand is the goal says."""
        if self._space is None:
            return True
        near = self._space.nearest(se3_of(base), posture, ARM, self._settings.clearance)
        if near.distance < self._settings.clearance:
            self._in_the_way.append(near.fixture)
            return False
        return True
