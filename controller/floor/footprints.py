"""Footprints: the part of a shape in a band of heights, seen from above."""

from __future__ import annotations

from math import hypot, pi, sqrt
from typing import NamedTuple

import numpy as np

from config.arrays import Array
from robots import Box, Capsule, Cylinder, Geom, Hull, Plane, Sphere

_SIDES = 32  # of the polygon around a cylinder that is not upright: at most 0.5 % too large
_ANGLES = np.arange(_SIDES) * (2.0 * pi / _SIDES)
_CIRCLE = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1) / np.cos(pi / _SIDES)
_RECTANGLE = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
_UPRIGHT = 1.0 - 1e-6  # cosine of the largest tilt of an upright cylinder


class Footprint(NamedTuple):
    """A convex polygon with round corners."""

    corners: Array  # (M, 2) counter-clockwise [m]: one for a circle, two for a stadium
    radius: float  # of the round corners [m]

    def equals(self, other: Footprint) -> bool:
        """Whether it is the same."""
        return np.array_equal(self.corners, other.corners) and self.radius == other.radius

    def distances(self, x: Array, y: Array) -> Array:
        """Signed distances of points x, y of any shapes that broadcast [m]."""
        outside, squared = np.array(-np.inf), np.array(np.inf)
        previous = np.roll(self.corners, 1, axis=0)
        for (ax, ay), (bx, by) in zip(previous.tolist(), self.corners.tolist(), strict=True):
            length = hypot(bx - ax, by - ay)
            ex, ey = ((bx - ax) / length, (by - ay) / length) if length > 0.0 else (1.0, 0.0)
            across = (x - ax) * ey - (y - ay) * ex
            along = (x - ax) * ex + (y - ay) * ey
            past = along - np.clip(along, 0.0, length)
            squared = np.minimum(squared, past * past + across * across)
            outside = np.maximum(outside, across)
        distance: Array = np.sqrt(squared)
        if len(self.corners) > 2:
            distance = np.copysign(distance, outside)
        return distance - self.radius


def footprint(geom: Geom, low: float, high: float) -> Footprint | None:
    """The footprint of a shape on the map between two heights [m].

    At most a few millimetres too large where a round shape is not upright. None if nothing of it is
    between the heights, and for a plane.
    """
    R, p = geom.pose.rotation, geom.pose.translation
    match geom.shape:
        case Box((a, b, c)):
            return _slice(_prism(_RECTANGLE * [a, b], c) @ R.T + p, low, high)
        case Cylinder(r, length) if abs(R[2, 2]) > _UPRIGHT:
            stands = p[2] - length <= high and p[2] + length >= low
            return Footprint(p[None, :2], r) if stands else None
        case Cylinder(r, length):
            return _slice(_prism(_CIRCLE * r, length) @ R.T + p, low, high)
        case Sphere(r):
            away = max(0.0, low - p[2], p[2] - high)
            return Footprint(p[None, :2], sqrt(r * r - away * away)) if away <= r else None
        case Capsule(r, length):
            axis = np.array([p - length * R[:, 2], p + length * R[:, 2]])[None]
            line = _slice(axis, low - r, high + r)
            return None if line is None else Footprint(line.corners, r)
        case Hull(vertices, triangles):
            corners = vertices @ R.T + p
            starts, ends = corners[triangles], corners[np.roll(triangles, -1, axis=1)]
            return _cut(corners, starts.reshape(-1, 3), ends.reshape(-1, 3), low, high)
        case Plane():
            return None


def _prism(ring: Array, half_length: float) -> Array:
    """(2, M, 3) a ring (M, 2) at both ends of a prism."""
    bottom = np.insert(ring, 2, -half_length, axis=1)
    top = np.insert(ring, 2, half_length, axis=1)
    return np.stack([bottom, top])


def _slice(rings: Array, low: float, high: float) -> Footprint | None:
    """The part between two heights of a convex body with these rings of corners (N, M, 3)."""
    points = rings.reshape(-1, 3)
    starts = np.concatenate([points, rings[:-1].reshape(-1, 3)])
    ends = np.concatenate([np.roll(rings, -1, axis=1).reshape(-1, 3), rings[1:].reshape(-1, 3)])
    return _cut(points, starts, ends, low, high)


def _cut(points: Array, starts: Array, ends: Array, low: float, high: float) -> Footprint | None:
    """The part between two heights of a convex body with corners (N, 3) and edges (E, 3)."""
    z = points[:, 2]
    if z.max() < low or z.min() > high:
        return None
    inside = (z >= low) & (z <= high)
    if inside.all():
        return Footprint(_hull(points[:, :2]), 0.0)
    corners = [points[inside, :2]]
    for height in (low, high):
        cut = (starts[:, 2] < height) != (ends[:, 2] < height)
        a, b = starts[cut], ends[cut]
        share = (height - a[:, 2:]) / (b[:, 2:] - a[:, 2:])
        corners.append((a + share * (b - a))[:, :2])
    return Footprint(_hull(np.concatenate(corners)), 0.0)


def _hull(points: Array) -> Array:
    """Corners (M, 2) of the convex hull of points (N, 2), counter-clockwise: a monotone chain."""
    ordered = sorted({(round(x, 9), round(y, 9)) for x, y in points.tolist()})
    if len(ordered) < 3:
        return np.array(ordered)
    corners: list[tuple[float, float]] = []
    for way in (ordered, ordered[::-1]):
        chain: list[tuple[float, float]] = []
        for x, y in way:
            while len(chain) > 1:
                (ax, ay), (bx, by) = chain[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 1e-12:
                    break
                chain.pop()
            chain.append((x, y))
        corners += chain[:-1]
    return np.array(corners)
