"""Stances whose tool poses are goals, and the proof that a stance can be reached.

The proof is a path that a simple planner would take, found with the judge's own geometry. The arm
folds above the base at the start. The base drives through cells of a grid in which the circle
around it has room, so that it may turn anywhere, to a place straight behind the stance; it docks
straight ahead; and the arm unfolds along a straight line of joint positions, before or after
docking.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.ndimage import label

from config.arrays import Mask
from config.planar import rotate
from controller import Array, RobotModel
from lab.bench.contacts import ContactChecker
from lab.bench.obstacles.contact_judge import Judge
from lab.bench.obstacles.convex_distances import signed_distance
from lab.bench.obstacles.judged_shapes import RobotShapes
from robots import Geom, half_extents

FOLDED = np.array([0.0, -1.2, 0.0, -2.0, 0.0, 1.1, np.pi / 4.0])
"""Joint positions in which no part of the arm leaves the circle around the base [rad]."""
STANCE_MARGIN = 0.03  # least distance to obstacles at the stance [m]
PATH_MARGIN = 0.02  # least distance to obstacles on the path [m]

_DRAWN, _SEED = 60_000, 7
_MARGIN = 0.15  # distance of postures from every joint limit [rad]
_MAX_BEARING = 1.0  # largest bearing of the tool seen from the foot of the arm [rad]
_LOWEST = 0.10  # least height of the tool and of the flange [m]
_DOWN = -0.9  # largest z of the approach direction of a hand that points down
_SLANTED = (-0.77, 0.2)  # the range of the same of a horizontal or slanted hand
_SAME_HEIGHT = 0.03  # a posture suits a point whose height differs by no more than this [m]
_CELL = 0.08  # of the grid [m]
_EXTENT = 5.6  # the grid reaches this far from the start [m]
_DOCKING = np.arange(0.0, 1.3, 0.2)  # distances behind the stance at which docking may begin [m]
_ARM_STEP = 0.05  # largest joint motion between two samples of unfolding [rad]
_BASE_STEP = 0.02  # between two samples of docking [m]
_TALL = 2.0  # upper bound of the height of the robot with its arm folded [m]


class Stance(NamedTuple):
    """Base and arm of the robot with its tool at a goal."""

    base: Array  # (3,) x, y [m] and heading [rad]
    q: Array  # (j,) joint positions [rad]


class Postures(NamedTuple):
    """N postures in which the arm does not touch itself, the base or the floor."""

    q: Array  # (N, j) [rad]
    tools: Array  # (N, 3) position of the tool in the base frame [m]
    approach: Array  # (N, 3) approach direction of the hand in the base frame

    def chosen(self, which: Mask) -> Postures:
        """Some of them."""
        return Postures(*(values[which] for values in self))

    @property
    def down(self) -> Postures:
        """Those with the hand down."""
        return self.chosen(self.approach[:, 2] < _DOWN)

    @property
    def slanted(self) -> Postures:
        """Those with the hand horizontal or slanted."""
        low, high = _SLANTED
        return self.chosen((low < self.approach[:, 2]) & (self.approach[:, 2] < high))


def draw_postures(model: RobotModel, checker: ContactChecker) -> Postures:
    """Postures of one robot, always the same."""
    rng, limits = np.random.default_rng(_SEED), model.limits
    q = rng.uniform(limits.q_min + _MARGIN, limits.q_max - _MARGIN, (_DRAWN, len(limits.q_min)))
    tool = RobotShapes(model.description).tool(np.zeros((_DRAWN, 3)), q)
    approach, place = tool.rotations[:, :, 2], tool.positions
    flange = place - approach * float(model.description.gripper.hTe.translation[2])
    foot = model.description.bTa.translation
    bearing = np.arctan2(place[:, 1] - foot[1], place[:, 0] - foot[0])
    good = (np.abs(bearing) < _MAX_BEARING) & (place[:, 2] > _LOWEST) & (flange[:, 2] > _LOWEST)
    found = Postures(q[good], place[good], approach[good])
    return found.chosen(np.array([not checker(posture) for posture in found.q]))


def stance_at(
    rng: np.random.Generator, postures: Postures, point: Array, yaw: float | None = None
) -> Stance | None:
    """A random stance with the tool at a point (3,) [m], in height up to 3 cm; None if none.

    `yaw` is the horizontal direction of the hand [rad]; None is any, with a random heading of the
    base.
    """
    suited = np.flatnonzero(np.abs(postures.tools[:, 2] - point[2]) < _SAME_HEIGHT)
    if not len(suited):
        return None
    number = rng.choice(suited)
    tool, (ax, ay, _) = postures.tools[number], postures.approach[number]
    heading = rng.uniform(-np.pi, np.pi) if yaw is None else yaw - np.arctan2(ay, ax)
    place = point[:2] - rotate(heading, *tool[:2])
    return Stance(np.array([*place, heading]), postures.q[number])


class Paths:
    """The paths of one robot through one world."""

    def __init__(
        self, model: RobotModel, judge: Judge, checker: ContactChecker, fixtures: Sequence[Geom]
    ) -> None:
        self._judge, self._checker, self._fixtures = judge, checker, fixtures
        self._circle = float(np.hypot(*model.description.base.size[:2])) / 2.0
        self._ready = model.description.arm.ready
        self._axis = np.arange(-_EXTENT, _EXTENT + _CELL / 2.0, _CELL)
        x, y = np.meshgrid(self._axis, self._axis, indexing="ij")
        free = self._room(np.stack([x, y], axis=-1)) > PATH_MARGIN + _CELL / 2.0
        self._regions, _ = label(free)
        self._start = self._region(np.zeros(2))

    def _room(self, places: Array) -> Array:
        """Distance of the circle around the base to the outlines of the fixtures (...,) [m]."""
        room = np.full(places.shape[:-1], np.inf)
        for fixture in self._fixtures:
            z, half = float(fixture.pose.translation[2]), half_extents(fixture.shape)[2]
            if z - half < _TALL and z + half > 0.0:
                points = np.zeros((*places.shape[:-1], 3))
                points[..., :2] = places - fixture.pose.translation[:2]
                room = np.minimum(
                    room, signed_distance(fixture.shape, points @ fixture.pose.rotation)
                )
        return room - self._circle

    def _region(self, place: Array) -> int:
        """Number of the connected region of free cells around a place; 0 is none."""
        i, k = np.rint((place + _EXTENT) / _CELL).astype(int)
        inside = 0 <= i < len(self._axis) and 0 <= k < len(self._axis)
        return int(self._regions[i, k]) if inside else 0

    @property
    def start_is_free(self) -> bool:
        """Whether the robot can start from the origin, arm ready, and fold its arm there."""
        if self._start == 0:
            return False
        return self._is_free(np.zeros((1, 3)), _arm_path(self._ready, FOLDED))

    def reaches(self, base: Array, q: Array) -> bool:
        """Whether a path leads to a stance: base (3,) x, y [m] and heading [rad], arm q (j,)."""
        unfolding = _arm_path(FOLDED, q)
        if any(self._checker(posture) for posture in unfolding):
            return False
        forward = np.array([np.cos(base[2]), np.sin(base[2]), 0.0])
        for distance in _DOCKING:
            begin = base - distance * forward
            if self._region(begin[:2]) != self._start:
                continue
            samples = max(2, round(distance / _BASE_STEP))
            docking = np.linspace(begin, base, samples)
            if self._is_free(docking, q[None]) and self._is_free(begin[None], unfolding):
                return True
            if self._is_free(docking, FOLDED[None]) and self._is_free(base[None], unfolding):
                return True
        return False

    def _is_free(self, base: Array, q: Array) -> bool:
        count = max(len(base), len(q))
        base, q = np.broadcast_to(base, (count, 3)), np.broadcast_to(q, (count, q.shape[1]))
        return bool((self._judge.clearances(base, q, self._fixtures) > PATH_MARGIN).all())


def _arm_path(start: Array, end: Array) -> Array:
    return np.linspace(start, end, max(2, int(np.ceil(np.abs(end - start).max() / _ARM_STEP))))
