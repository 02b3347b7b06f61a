"""Distances and first contacts between placed convex shapes.

First contacts are found by conservative advancement: two convex shapes a gap d apart, with the
normal n of the plane between them, cannot meet before one has gone d / (n·a) along a towards the
other. Repeating this step converges on the first touch and never passes it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import coal
import numpy as np
from pinocchio import SE3

from robots import Array, Geom, coal_geometry, half_extents

TOUCH = 2e-5  # Largest gap that counts as a touch [m]

GRAZE = 0.1
"""Smallest cosine between normal and motion at a touch; shapes that slide past do not touch."""

_EXACT = 1e-9  # A smaller gap, or overlap, is rounding [m]

_STEPS = 60

_distance_request = coal.DistanceRequest()
_distance_request.enable_signed_distance = True
_collision_request = coal.CollisionRequest()
_collision_request.enable_contact = True
_patch_request = coal.ContactPatchRequest()


def separation(a: Geom, b: Geom) -> tuple[float, Array]:
    """Signed distance of two shapes and the (3,) unit normal from a to b, in the world.

    Returns:
        The gap [m], negative when they overlap, and the normal.
    """
    return _separation(coal_geometry(a.shape), _transform(a.pose), b, _transform(b.pose))


def travel(moving: Geom, direction: Array, still: Iterable[Geom], limit: float) -> float | None:
    """How far a shape can move along a unit direction (3,) until it first touches another [m].

    Returns:
        The distance, 0 if it touches already; None if it moves `limit` [m] without a touch.
    """
    nearest: float | None = None
    for other in still:
        distance = _travel(moving, direction, other, limit if nearest is None else nearest)
        nearest = nearest if distance is None else distance
    return nearest


def patch(a: Geom, b: Geom) -> tuple[Array, Array] | None:
    """Where two slightly overlapping shapes press on each other.

    Returns:
        (N, 3) corners of the contact patch and the (3,) unit normal from a to b, in the world;
        None if they do not overlap.
    """
    shapes = (
        coal_geometry(a.shape),
        _transform(a.pose),
        coal_geometry(b.shape),
        _transform(b.pose),
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
    """Finds quickly which of many static shapes are near a point.

    Args:
        shapes: in the world.
    """

    def __init__(self, shapes: Sequence[Geom]) -> None:
        self._shapes = tuple(shapes)
        self._rotation = np.array([s.pose.rotation for s in shapes]).reshape(-1, 3, 3)
        self._position = np.array([s.pose.translation for s in shapes]).reshape(-1, 3)
        self._half = np.array([half_extents(s.shape) for s in shapes]).reshape(-1, 3)

    def near(self, point: Array, radius: float) -> list[Geom]:
        """The shapes whose bounding box is less than `radius` [m] from the (3,) world point."""
        local = np.einsum("ni,nij->nj", point - self._position, self._rotation)
        outside = np.maximum(np.abs(local) - self._half, 0.0)
        near = np.einsum("ni,ni->n", outside, outside) < radius * radius
        return [self._shapes[i] for i in np.flatnonzero(near)]


def _travel(moving: Geom, direction: Array, still: Geom, limit: float) -> float | None:
    geometry = coal_geometry(moving.shape)
    start = np.array(moving.pose.translation)
    here, there = _transform(moving.pose), _transform(still.pose)
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
    gap = coal.distance(
        geometry, pose, coal_geometry(other.shape), other_pose, _distance_request, result
    )
    return gap, result.normal.copy()


def _transform(pose: SE3) -> Any:
    return coal.Transform3s(pose.rotation, pose.translation)
