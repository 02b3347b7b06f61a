"""The search for a stance, a bounded piece of it in every step of control.

The bank's postures near the goal's height and tilt are ranked by what they would cost, the best are
refined until they have exactly that height and tilt, and the best of those is taken whose base and
arm stand free and whose fold, the straight path in joint space, is clear of contact.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from math import cos, inf, sin
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from controller.base_drive import Pose2D
from controller.command import Array
from controller.free_space import ARM, WHOLE, FreeSpace, group_names, se3_of
from controller.model import RobotModel
from controller.postures import Bank, ToolPoses, forward_kinematics
from controller.self_collision import SelfCollision
from controller.settings import StanceSettings
from controller.stance import REACHED, Stance, Start, base_poses, refine, stance_costs

Indices: TypeAlias = npt.NDArray[np.int64]
Mask: TypeAlias = npt.NDArray[np.bool_]

_WINDOWS = ((0.08, 0.96), (0.2, 0.85))
"""How far the height [m] and tilt (a cosine) of a posture may be from the goal's before refinement:
the first window that holds enough postures is taken, and among fixtures the next ones after it."""
_MIN_CANDIDATES = 12
"""A window with fewer postures than this is too narrow."""
_FALLBACK_CANDIDATES = 300
"""Nearest postures that are ranked where every window is too narrow."""
_METRES_PER_TILT = 0.3
"""What the cosine of the tilt counts like in that search [m]."""

RANKED = 400
"""Postures that are ranked in one step."""
BATCH = 12
"""Postures that are refined in one step, the best first."""
FOLDS = 2
"""Folds that are checked in one step ..."""
POSTURES = 10
"""... and postures among fixtures, those of one fold more at most."""
_MAX_BATCHES = 3
"""Batches of a window that are refined before the best posture so far is taken, good enough or
not."""

_PATH_SAMPLES = np.linspace(0.0, 1.0, 17)[1:, None]
"""Where the fold is checked for contact of the robot with itself and the floor."""
_FOLD_HERE = (0.3, 0.6)
"""Where it is checked for contact with fixtures, the base where it stands now ..."""
_FOLD_THERE = ((0.4, 0.8), (0.4, 1.0), (0.2, 1.0))
"""... and so far before the stance [m]."""


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
    """

    def __init__(
        self,
        model: RobotModel,
        settings: StanceSettings,
        bank: Bank,
        collision: SelfCollision,
        wTe: SE3,
        wTb: Pose2D,
        q: Array,
        failed: tuple[Stance, ...] = (),
        space: FreeSpace | None = None,
    ) -> None:
        self._model = model
        self._settings = settings
        self._bank = bank
        self._collision = collision
        self._wTe = wTe
        self._failed = failed
        self._space = space
        self._start = Start(wTb, q.copy())
        self.best: Stance | None = None
        """The best stance so far; None if there is none."""
        self.error = inf
        """Least error of height and tilt of any posture so far [m + rad]."""
        self.blocked = ""
        """What keeps the stances that were looked at from standing free, for people."""
        self.base_stands = self.base_gets_there = False
        """Whether the base stands free in any of them, and whether there is a way to one."""
        self.done = False
        """Whether the search is over: `best` is good enough, or nothing better was found."""
        self._cost = inf
        self._in_the_way: list[str] = []
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
        space, tried = self._space, np.zeros(0, np.int64)
        if space is not None:
            here = self._start.wTb
            self._start = self._start._replace(
                floor=space.floor, way=space.floor.field((here.x, here.y))
            )
            yield
        for candidates in self._windows():
            ranked = yield from self._rank(np.setdiff1d(candidates, tried))
            tried = candidates
            for first in range(0, min(len(ranked), _MAX_BATCHES * BATCH), BATCH):
                yield
                postures, errors = refine(
                    self._model, self._settings, self._wTe, self._bank.q[ranked[first:][:BATCH]]
                )
                self.error = min(self.error, float(errors.min()))
                yield
                yield from self._judge(postures, errors)
                if self._cost < self._settings.failed_cost:
                    return
        self.blocked = group_names(self._in_the_way)

    def _windows(self) -> Iterator[Indices]:
        """Indices of the postures whose end effector is about as high and as tilted as the goal."""
        heights, verticals = self._bank.tools.positions[:, 2], self._bank.tools.rotations[:, 2]
        height, vertical = self._wTe.translation[2], self._wTe.rotation[2]
        enough = False
        for window, min_cosine in _WINDOWS:
            first, last = np.searchsorted(heights, [height - window, height + window])
            found: Indices = first + np.flatnonzero(verticals[first:last] @ vertical > min_cosine)
            if len(found) >= _MIN_CANDIDATES:
                enough = True
                yield found
                if self._space is None:
                    return
        if not enough:
            distance = np.abs(heights - height) - _METRES_PER_TILT * (verticals @ vertical)
            yield np.argpartition(distance, _FALLBACK_CANDIDATES)[:_FALLBACK_CANDIDATES]

    def _rank(self, candidates: Indices) -> Generator[None, None, Indices]:
        """The candidates that stand free and that the base gets to, the cheapest first."""
        costs = np.empty(len(candidates))
        for first in range(0, len(candidates), RANKED):
            if first:
                yield
            some = candidates[first : first + RANKED]
            tools = ToolPoses(*(values[some] for values in self._bank.tools))
            costs[first : first + RANKED] = self._costs(self._bank.q[some], tools)[0]
        order = np.argsort(costs)
        return candidates[order[: np.searchsorted(costs[order], inf)]]

    def _costs(self, postures: Array, tools: ToolPoses) -> tuple[Array, Array, Mask]:
        """Costs (N,) [s], infinite if not free, base poses (N, 3), and whether it backs (N,)."""
        bases = base_poses(self._wTe, tools)
        costs, reverse = stance_costs(
            self._model, self._settings, self._start, bases, postures, tools
        )
        if self._space is not None:
            free = self._space.floor.stands_free(bases) >= self._settings.standing_room
            self.base_stands = self.base_stands or bool(free.any())
            self.base_gets_there = self.base_gets_there or bool(np.isfinite(costs[free]).any())
            if not free.any():
                for base in bases[np.argsort(costs)[:3]]:
                    room = self._settings.standing_room
                    self._in_the_way += self._space.blocking(Pose2D(*base.tolist()), room)
            costs = np.where(free, costs, inf)
        return costs, bases, reverse

    def _judge(self, postures: Array, errors: Array) -> Iterator[None]:
        """Keep the best of postures (N, 7) with these errors (N,), if it is the best so far."""
        settings = self._settings
        tools = forward_kinematics(self._model.description, postures)
        costs, bases, reverse = self._costs(postures, tools)
        unreached = settings.unreached_cost
        costs = costs + np.where(errors > REACHED, unreached + unreached * errors, 0.0)
        for stance in self._failed:
            same = np.abs(postures - stance.q).max(axis=1) < settings.joint_difference
            costs = costs + np.where(same, settings.failed_cost, 0.0)
        folds = looked_at = 0
        for one in np.argsort(costs):
            cost, base = float(costs[one]), Pose2D(*bases[one].tolist())
            if cost >= self._cost:
                return
            if folds == FOLDS or looked_at >= POSTURES:
                yield
                folds = looked_at = 0
            looked_at += 1
            if not self._arm_is_free(base, postures[one]):
                continue
            folds += 1
            looked_at += len(_FOLD_HERE) + len(_FOLD_THERE) + 1
            stance = Stance(
                postures[one], SE3(tools.rotations[one], tools.positions[one]), bool(reverse[one])
            )
            cost += self._cost_of_contact(base, stance)
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

    def _cost_of_contact(self, base: Pose2D, stance: Stance) -> float:
        """What contact on the fold costs [s]."""
        settings, q = self._settings, self._start.q
        way = stance.q - q
        clearance = min(self._collision.clearance(p) for p in q + _PATH_SAMPLES * way)
        missing = max(0.0, settings.clearance - clearance)
        if self._space is not None:
            missing += self._missing_to_fixtures(base, stance)
        return settings.contact_cost * missing

    def _missing_to_fixtures(self, base: Pose2D, stance: Stance) -> float:
        """How much clearance from fixtures the fold lacks, at most all of it [m]."""
        assert self._space is not None
        space, q, needed = self._space, self._start.q, self._settings.clearance
        here, way = se3_of(self._start.wTb), stance.q - q
        least = space.nearest(here, q, WHOLE, needed).distance  # no better where it stands now
        clearance = min(
            space.nearest(here, q + share * way, WHOLE, needed).distance for share in _FOLD_HERE
        )
        missing = max(0.0, least - max(0.0, clearance))
        forward = -1.0 if stance.reverse else 1.0
        for before, share in _FOLD_THERE:
            x = base.x - forward * before * cos(base.heading)
            y = base.y - forward * before * sin(base.heading)
            there = se3_of(Pose2D(x, y, base.heading))
            near = space.nearest(there, q + share * way, WHOLE, needed)
            missing = max(missing, needed - max(0.0, near.distance))
        return missing
