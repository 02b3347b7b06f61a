"""Exact distances between convex shapes, for many poses at once; independent of the controller.

The distance to a convex shape is a convex function of the point, and analytic for a box, an upright
cylinder and the floor. The least distance of a segment follows from it by golden-section search. A
capsule is one segment. Two boxes are nearest to each other at an edge of one of them; a box and a
cylinder at an edge of the box, or at a generator of the cylinder that faces one of its sides.

Distances are negative inside: the depth of the deepest of those segments.
"""

from __future__ import annotations

from itertools import product
from math import sqrt
from typing import NamedTuple

import numpy as np

from config.arrays import Array, Indices
from robots import Box, Capsule, Cylinder, Geom, Plane, Shape, bounding_radius

_GOLDEN = (sqrt(5.0) - 1.0) / 2.0
_SECTIONS = 22  # of the golden-section search: 1.5 m shrink to less than 0.1 mm

_CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))
_EDGES = np.array(
    [
        (a, b)
        for a in _CORNERS
        for b in _CORNERS
        if (np.abs(a - b) > 0.0).sum() == 1 and tuple(a) < tuple(b)
    ]
)
"""(12, 2, 3) the ends of the edges of a box of half extents 1."""


class Placed(NamedTuple):
    """A shape in k poses."""

    shape: Shape
    rotations: Array  # (k, 3, 3)
    positions: Array  # (k, 3) [m]

    @classmethod
    def fixed(cls, geom: Geom, count: int) -> Placed:
        """A shape in one pose, repeated."""
        R, p = geom.pose.rotation, geom.pose.translation
        return cls(geom.shape, np.broadcast_to(R, (count, 3, 3)), np.broadcast_to(p, (count, 3)))

    def at(self, chosen: Indices) -> Placed:
        """Only some of the poses."""
        return Placed(self.shape, self.rotations[chosen], self.positions[chosen])

    def outward(self, points: Array) -> Array:
        """Points (k, ..., 3) from the shape's own frame to the world."""
        moved = np.einsum("kij,k...j->k...i", self.rotations, points)
        return np.asarray(moved + _spread(self.positions, points))

    def inward(self, points: Array) -> Array:
        """Points (k, ..., 3) from the world to the shape's own frame."""
        relative = points - _spread(self.positions, points)
        return np.asarray(np.einsum("kji,k...j->k...i", self.rotations, relative))


def _spread(positions: Array, points: Array) -> Array:
    return positions.reshape(len(positions), *(1,) * (points.ndim - 2), 3)


def signed_distance(shape: Shape, points: Array) -> Array:
    """Distance of points (..., 3) to a shape in its own frame, negative inside [m]."""
    match shape:
        case Box(half):
            beyond = np.abs(points) - np.array(half)
        case Cylinder(radius, half_length):
            across = np.hypot(points[..., 0], points[..., 1]) - radius
            beyond = np.stack([across, np.abs(points[..., 2]) - half_length], axis=-1)
        case Plane():
            return np.asarray(points[..., 2])
        case _:
            raise ValueError(f"no distance to a {type(shape).__name__}")
    outside = np.sqrt((np.maximum(beyond, 0.0) ** 2).sum(axis=-1))
    return np.asarray(outside + np.minimum(beyond.max(axis=-1), 0.0))


def segment_distance(shape: Shape, starts: Array, ends: Array) -> Array:
    """Least distance of segments to a shape, ends (..., 3) in its own frame [m]."""
    span = ends - starts

    def at(share: Array) -> Array:
        return signed_distance(shape, starts + share[..., None] * span)

    low, high = np.zeros(starts.shape[:-1]), np.ones(starts.shape[:-1])
    x1, x2 = low + 1.0 - _GOLDEN, low + _GOLDEN
    f1, f2 = at(x1), at(x2)
    least = np.minimum(at(low), at(high))
    for _ in range(_SECTIONS):
        left = f1 < f2
        low, high = np.where(left, low, x1), np.where(left, x2, high)
        step = _GOLDEN * (high - low)
        new = np.where(left, high - step, low + step)
        f = at(new)
        x1, x2 = np.where(left, new, x2), np.where(left, x1, new)
        f1, f2 = np.where(left, f, f2), np.where(left, f1, f)
    return np.asarray(np.minimum(least, np.minimum(f1, f2)))


def distances(part: Placed, around: Placed, within: float) -> Array:
    """(k,) distances of a box or capsule of the robot to an obstacle [m].

    Those larger than `within` may be infinite.
    """
    result = np.full(len(part.positions), np.inf)
    centre = signed_distance(around.shape, around.inward(part.positions))
    near = np.flatnonzero(centre - bounding_radius(part.shape) < within)
    if len(near):
        result[near] = _distances(part.at(near), around.at(near))
    return result


def _distances(part: Placed, around: Placed) -> Array:
    match part.shape:
        case Capsule(radius, half_length):
            axis = np.zeros((len(part.positions), 2, 3))
            axis[:, :, 2] = (-half_length, half_length)
            ends = around.inward(part.outward(axis))
            return segment_distance(around.shape, ends[:, 0], ends[:, 1]) - radius
        case Box(half):
            edges = np.broadcast_to(_EDGES * half, (len(part.positions), 12, 2, 3))
            ends = around.inward(part.outward(edges))
            least = segment_distance(around.shape, ends[:, :, 0], ends[:, :, 1]).min(axis=1)
            lines = _lines(around, part)
            if lines is None:
                return np.asarray(least)
            ends = part.inward(around.outward(lines))
            back = segment_distance(part.shape, ends[:, :, 0], ends[:, :, 1]).min(axis=1)
            return np.asarray(np.minimum(least, back))
        case _:
            raise ValueError(f"no distance of a {type(part.shape).__name__}")


def _lines(around: Placed, part: Placed) -> Array | None:
    """(k, n, 2, 3) segments, in its own frame, at which an obstacle can be nearest to a box."""
    match around.shape:
        case Box(half):
            return np.broadcast_to(_EDGES * half, (len(part.positions), 12, 2, 3))
        case Cylinder(radius, half_length):
            # Sides of the box seen from the cylinder: (k, 3 sides, 2 of x and y).
            sides = np.einsum("kij,kil->klj", around.rotations, part.rotations)[:, :, :2]
            length = np.maximum(np.linalg.norm(sides, axis=2, keepdims=True), 1e-12)
            rim = radius * np.concatenate([sides / length, -sides / length], axis=1)
            lines = np.zeros((len(rim), 6, 2, 3))
            lines[:, :, :, :2] = rim[:, :, None, :]
            lines[:, :, :, 2] = (-half_length, half_length)
            return lines
        case _:
            return None
