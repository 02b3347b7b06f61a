"""Proof that a stance can be reached: a way that the judge's own geometry finds free.

The way is one that a planner without any finesse would take. The arm folds above the base at the
start. The base drives along cells of a grid in which the circle around it has room, so it may turn
wherever it likes, to a place straight behind the stance; it docks straight ahead; and the arm
unfolds along a straight line of joint positions, before or after docking.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import label

from controller import Array, RobotModel
from lab.bench.contacts import ContactChecker
from lab.bench.obstacle_judge import Judge
from lab.bench.obstacle_shapes import signed_distance
from robots import Box, Cylinder, Geom

FOLDED = np.array([0.0, -1.2, 0.0, -2.0, 0.0, 1.1, np.pi / 4.0])
"""Joint positions in which no part of the arm leaves the circle around the base [rad]."""
STANCE_MARGIN = 0.03
"""Distance to everything at the stance [m]."""
WAY_MARGIN = 0.02
"""Distance to everything on the way [m]."""

_CELL = 0.08
"""Of the grid [m]; no point between two cells that are neighbours is farther from one than half."""
_EXTENT = 5.6
"""The grid reaches this far from the start [m]."""
_DOCKING = np.arange(0.0, 1.3, 0.2)
"""How far behind the stance docking may begin [m]."""
_ARM_STEP = 0.05
"""Largest joint motion between two samples of unfolding [rad]."""
_BASE_STEP = 0.02
"""Between two samples of docking [m]."""
_TALL = 2.0
"""The robot with its arm folded is lower than this [m]."""


class Ways:
    """The ways of one robot through one world.

    Args:
        model: the robot.
        judge: of the same robot.
        checker: of the same robot; the arm must not touch itself either.
        fixtures: what stands in the world.
    """

    def __init__(
        self,
        model: RobotModel,
        judge: Judge,
        checker: ContactChecker,
        fixtures: Sequence[Geom],
    ) -> None:
        self._judge, self._checker, self._fixtures = judge, checker, fixtures
        self._circle = float(np.hypot(*model.description.base.size[:2])) / 2.0
        self._ready = model.description.arm.ready
        self._axis = np.arange(-_EXTENT, _EXTENT + _CELL / 2.0, _CELL)
        x, y = np.meshgrid(self._axis, self._axis, indexing="ij")
        free = self._room(np.stack([x, y], axis=-1)) > WAY_MARGIN + _CELL / 2.0
        self._regions, _ = label(free)
        self._start = self._region(np.zeros(2))

    def _room(self, places: Array) -> Array:
        """Distance of the circle around the base to the outlines of the fixtures (...,)."""
        room = np.full(places.shape[:-1], np.inf)
        for fixture in self._fixtures:
            bottom, top = _heights(fixture)
            if bottom < _TALL and top > 0.0:
                points = np.zeros((*places.shape[:-1], 3))
                points[..., :2] = places - fixture.pose.translation[:2]
                room = np.minimum(
                    room, signed_distance(fixture.shape, points @ fixture.pose.rotation)
                )
        return room - self._circle

    def _region(self, place: Array) -> int:
        """Which connected part of the free grid a place is in; 0 is none."""
        i, k = np.rint((place + _EXTENT) / _CELL).astype(int)
        inside = 0 <= i < len(self._axis) and 0 <= k < len(self._axis)
        return int(self._regions[i, k]) if inside else 0

    @property
    def start_is_free(self) -> bool:
        """Whether the robot can start from the origin, arm ready, and fold its arm there."""
        if self._start == 0:
            return False
        return self._is_free(np.zeros((1, 3)), _arm_way(self._ready, FOLDED))

    def reaches(self, base: Array, q: Array) -> bool:
        """Whether there is a way to a stance: base (3,) x, y [m] and heading [rad], arm q (7,)."""
        unfolding = _arm_way(FOLDED, q)
        if any(self._checker(posture).any for posture in unfolding):
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
        base, q = np.broadcast_to(base, (count, 3)), np.broadcast_to(q, (count, 7))
        return bool((self._judge.clearances(base, q, self._fixtures) > WAY_MARGIN).all())


def _arm_way(start: Array, end: Array) -> Array:
    return np.linspace(start, end, max(2, int(np.ceil(np.abs(end - start).max() / _ARM_STEP))))


def _heights(fixture: Geom) -> tuple[float, float]:
    match fixture.shape:
        case Box((_, _, half)) | Cylinder(_, half):
            z = float(fixture.pose.translation[2])
            return z - half, z + half
        case _:
            raise ValueError(f"not a fixture: {type(fixture.shape).__name__}")
