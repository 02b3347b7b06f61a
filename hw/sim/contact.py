"""Contacts of convex shapes: distances, first contacts, and objects at rest on their supports.

First contacts are found by conservative advancement: two convex shapes a gap d apart, with the
normal n of the plane between them, cannot meet before one has moved d / (n·a) along a towards the
other. Repeating this step converges on the first touch and never passes it.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import coal
import numpy as np
from pinocchio import SE3

from hw.sim.sim_object import SimObject
from robots import Array, Geom, Plane, coal_geometry, half_extents, reach

TOUCH = 2e-5  # largest gap that counts as a touch [m]
GRAZE = 0.1  # smallest cosine between normal and motion at a touch; below it shapes slide past
_EXACT = 1e-9  # a smaller gap, or overlap, is rounding [m]
_STEPS = 60
_SIDE_TOLERANCE = 0.005  # overlap from the side above which objects are pushed apart [m]
_MAX_FALL = 3.0  # [m]
_LIFT_STEP, _MAX_LIFTS = 0.005, 60
_RESTING_GAP = 0.0015  # largest gap to a support [m]
_DOWN = np.array([0.0, 0.0, -1.0])

SIGNED = coal.DistanceRequest()  # of distances below 0 where shapes overlap
SIGNED.enable_signed_distance = True
_collision_request = coal.CollisionRequest()
_collision_request.enable_contact = True
_patch_request = coal.ContactPatchRequest()


def separation(a: Geom, b: Geom) -> tuple[float, Array]:
    """Signed distance of two shapes [m] and the (3,) unit normal from a to b, in the world."""
    return _separation(coal_geometry(a.shape), transform(a.pose), b, transform(b.pose))


def travel(moving: Geom, direction: Array, still: Iterable[Geom], limit: float) -> float | None:
    """How far a shape moves along (3,) until a touch [m]; 0: it touches; None: not in `limit`."""
    nearest: float | None = None
    for other in still:
        distance = _travel(moving, direction, other, limit if nearest is None else nearest)
        nearest = nearest if distance is None else distance
    return nearest


def patch(a: Geom, b: Geom) -> tuple[Array, Array] | None:
    """Where two overlapping shapes press: corners (N, 3), unit normal (3,) from a to b; or None."""
    shapes = (
        coal_geometry(a.shape),
        transform(a.pose),
        coal_geometry(b.shape),
        transform(b.pose),
    )
    contacts = coal.CollisionResult()
    coal.collide(*shapes, _collision_request, contacts)
    if not contacts.isCollision():
        return None
    patches = coal.ContactPatchResult(_patch_request)
    coal.computeContactPatch(*shapes, contacts, _patch_request, patches)
    if patches.numContactPatches() == 0:
        contact = contacts.getContact(0)
        return np.array([contact.pos]), np.array(contact.normal)
    found = patches.getContactPatch(0)
    points = np.array([found.getPoint(i) for i in range(found.size())]).reshape(-1, 3)
    return points, np.array(found.getNormal())


class Vicinity:
    """Broad phase: which of many static shapes (in the world) are near a point."""

    def __init__(self, shapes: Sequence[Geom]) -> None:
        self._shapes = tuple(shapes)
        self._rotation = np.array([s.pose.rotation for s in shapes]).reshape(-1, 3, 3)
        self._position = np.array([s.pose.translation for s in shapes]).reshape(-1, 3)
        self._half = np.array([half_extents(s.shape) for s in shapes]).reshape(-1, 3)

    def near(self, point: Array, radius: float) -> list[Geom]:
        """The shapes whose bounding box is less than `radius` [m] from a (3,) world point."""
        local = np.einsum("ni,nij->nj", point - self._position, self._rotation)
        outside = np.maximum(np.abs(local) - self._half, 0.0)
        near = np.einsum("ni,ni->n", outside, outside) < radius * radius
        return [self._shapes[i] for i in np.flatnonzero(near)]


class Resting:
    """The objects of a world at rest on its fixtures and on each other."""

    def __init__(
        self, fixtures: Sequence[Geom], objects: Sequence[SimObject], vicinity: Vicinity
    ) -> None:
        self._fixtures = fixtures
        self._objects = objects
        self._vicinity = vicinity

    def support(self, obj: SimObject, held: SimObject | None) -> str:
        """Group of the fixture that carries an object, or `hand`; empty if nothing does."""
        return self._support(obj, held, frozenset())

    def drop(self, obj: SimObject, held: SimObject | None) -> None:
        """Let an object fall to its first contact, lifted until it is free of what is below it."""
        below = [
            *self._fixtures,
            *(part for o in self._others_below(obj, held, _MAX_FALL) for part in o.placed()),
        ]
        lifting = [one for one in below if _bottom(one) < obj.pose.translation[2]]
        for _ in range(_MAX_LIFTS):
            if not any(_overlapping(a, b) for a in obj.placed() for b in lifting):
                break
            obj.pose = _moved(obj.pose, -_LIFT_STEP * _DOWN)
        falls = [travel(part, _DOWN, below, _MAX_FALL) for part in obj.placed()]
        fall = min((f for f in falls if f is not None), default=0.0)
        obj.pose = _moved(obj.pose, fall * _DOWN)

    def push(self, obj: SimObject, way: Array, held: SimObject | None) -> None:
        """Let an object slide along a level way (3,) [m], until something blocks it."""
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
        """Let every object without a support fall, the lowest first."""
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
                return fixture.piece
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


def _travel(moving: Geom, direction: Array, still: Geom, limit: float) -> float | None:
    geometry = coal_geometry(moving.shape)
    start = np.array(moving.pose.translation)
    here, there = transform(moving.pose), transform(still.pose)
    gone = before = 0.0
    for _ in range(_STEPS):
        gap, normal = _separation(geometry, here, still, there)
        closing = float(normal @ direction)
        if gap <= TOUCH:
            if abs(gap) <= _EXACT:  # there the normal may be any; a step before it was not
                closing = max(closing, before)
            return gone if closing > GRAZE else None
        if closing <= 1e-4:
            return None
        before = closing
        gone += gap / closing
        if gone > limit:
            return None
        here.setTranslation(start + gone * direction)
    return gone


def _separation(geometry: Any, pose: Any, other: Geom, other_pose: Any) -> tuple[float, Array]:
    result = coal.DistanceResult()
    gap = coal.distance(geometry, pose, coal_geometry(other.shape), other_pose, SIGNED, result)
    return gap, result.normal.copy()


def transform(pose: SE3) -> Any:
    """A pose for Coal."""
    return coal.Transform3s(pose.rotation, pose.translation)


def _overlapping(a: Geom, b: Geom) -> bool:
    gap, normal = separation(a, b)
    return gap < -_SIDE_TOLERANCE or (gap < -TOUCH and abs(normal[2]) > 0.5)


def _presses_down(a: Geom, b: Geom) -> bool:
    """Whether b carries a, however steep the contact is."""
    gap, normal = separation(a, b)
    return gap < 0.0 and normal[2] < -GRAZE


def _bottom(geom: Geom) -> float:
    """Height of its lowest point [m]; a plane has none."""
    return -np.inf if isinstance(geom.shape, Plane) else -reach(geom, _DOWN)


def _moved(pose: SE3, way: Array) -> SE3:
    return SE3(pose.rotation, pose.translation + way)
