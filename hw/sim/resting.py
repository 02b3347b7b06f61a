"""What carries the objects: what each rests on, and where it falls or slides to."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from pinocchio import SE3

from hw.sim.contact import GRAZE, TOUCH, Vicinity, separation, travel
from hw.sim.sim_object import SimObject
from robots import Array, Geom

SIDE_TOLERANCE = 0.005
"""Depth to which things may overlap from the side before they are pushed apart [m]."""

_DOWN = np.array([0.0, 0.0, -1.0])
_MAX_FALL = 3.0
_LIFT_STEP = 0.005
_MAX_LIFTS = 60
_RESTING_GAP = 0.0015


class Resting:
    """The objects of a world as they lie on its fixtures and on each other.

    Args:
        fixtures: in the world.
        objects: of the world.
        vicinity: of the fixtures.
    """

    def __init__(
        self, fixtures: Sequence[Geom], objects: Sequence[SimObject], vicinity: Vicinity
    ) -> None:
        self._fixtures = fixtures
        self._objects = objects
        self._vicinity = vicinity

    def support(self, obj: SimObject, held: SimObject | None) -> str:
        """Group of the fixture that carries an object, directly or through others.

        Returns:
            For example `container` or `table`; `hand` if held, empty if nothing carries it.
        """
        return self._support(obj, held, frozenset())

    def drop(self, obj: SimObject, held: SimObject | None) -> None:
        """Let an object fall to its first contact, lifted until it is free."""
        below = [
            *self._fixtures,
            *(part for o in self._others_below(obj, held, _MAX_FALL) for part in o.placed()),
        ]
        for _ in range(_MAX_LIFTS):
            if not any(_overlapping(a, b) for a in obj.placed() for b in below):
                break
            obj.pose = _moved(obj.pose, -_LIFT_STEP * _DOWN)
        falls = [travel(part, _DOWN, below, _MAX_FALL) for part in obj.placed()]
        fall = min((f for f in falls if f is not None), default=0.0)
        obj.pose = _moved(obj.pose, fall * _DOWN)

    def push(self, obj: SimObject, way: Array, held: SimObject | None) -> None:
        """Let an object slide along a level way (3,) [m], until something stops it."""
        length = float(np.linalg.norm(way))
        direction, reach = way / length, obj.radius + length
        others = self._vicinity.near(obj.pose.translation, reach)
        for other in self._objects:
            apart = np.linalg.norm(other.pose.translation - obj.pose.translation)
            if other is not obj and other is not held and apart < reach + other.radius:
                others += other.placed()
        slides = [travel(part, direction, others, length) for part in obj.placed()]
        slide = min((s for s in slides if s is not None), default=length)
        obj.pose = _moved(obj.pose, min(slide, length) * direction)

    def settle(self, held: SimObject | None) -> None:
        """Let every object that nothing carries any more fall, the lowest first."""
        for obj in sorted(self._objects, key=lambda o: float(o.pose.translation[2])):
            if obj.motion is None and not self.support(obj, held):
                self.drop(obj, held)

    def _support(self, obj: SimObject, held: SimObject | None, visited: frozenset[str]) -> str:
        if obj is held:
            return "hand"
        parts = [part.moved(SE3(np.eye(3), _RESTING_GAP * _DOWN)) for part in obj.placed()]
        around = self._vicinity.near(obj.pose.translation, obj.radius + _RESTING_GAP)
        for fixture in around:
            if any(_presses_down(part, fixture) for part in parts):
                return fixture.name.split("/")[0]
        for other in self._others_below(obj, held, _RESTING_GAP):
            touching = any(_presses_down(a, b) for a in parts for b in other.placed())
            if touching and other.name not in visited:
                found = self._support(other, held, visited | {obj.name})
                if found:
                    return found
        return ""

    def _others_below(
        self, obj: SimObject, held: SimObject | None, depth: float
    ) -> Iterable[SimObject]:
        """Objects that another may meet while it falls by `depth` [m], or rises."""
        x, y, z = obj.pose.translation
        for other in self._objects:
            if other is obj or other is held:
                continue
            ox, oy, oz = other.pose.translation
            reach = other.radius + obj.radius
            if np.hypot(ox - x, oy - y) < reach and oz < z + reach + depth:
                yield other


def _overlapping(a: Geom, b: Geom) -> bool:
    """Whether two shapes overlap by more than a touch from the side."""
    gap, normal = separation(a, b)
    return gap < -SIDE_TOLERANCE or (gap < -TOUCH and abs(normal[2]) > 0.5)


def _presses_down(a: Geom, b: Geom) -> bool:
    """Whether b carries a: what stops a fall does, however steep it is."""
    gap, normal = separation(a, b)
    return gap < 0.0 and normal[2] < -GRAZE


def _moved(pose: SE3, way: Array) -> SE3:
    return SE3(pose.rotation, pose.translation + way)
