"""Convex hulls around point sets and geometries: never tighter than what they stand for."""

from __future__ import annotations

from typing import Any

import coal
import numpy as np
from pinocchio import SE3
from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

from robots import CORNERS, Array, Geom, hull_of

_ROUND = 32  # corners of a circle
_MOST = 200  # corners of a hull; where it has more, planes in these directions stand for it
_HEIGHTS, _TURNS = np.linspace(-1.0, 1.0, 81)[1::2], np.pi * (5.0**0.5 - 1.0) * np.arange(40)
_WIDER, _THIN = 1.001, 1e-4  # for the digits of the file, and half thickness of what is flat [m]

_ACROSS = np.sqrt(1.0 - _HEIGHTS**2)
_DIRECTIONS = np.stack([_ACROSS * np.cos(_TURNS), _ACROSS * np.sin(_TURNS), _HEIGHTS], axis=1)
_DIRECTIONS = np.vstack([_DIRECTIONS, np.eye(3), -np.eye(3)])


def placed_points(geometry: Any, pose: SE3) -> Array:
    """Points (N, 3) whose hull holds a geometry of Coal at a pose."""
    match geometry:
        case coal.Box():
            points = CORNERS * geometry.halfSide
        case coal.Sphere():
            points = _between_planes(np.full(len(_DIRECTIONS), geometry.radius), np.zeros(3))
        case coal.Cylinder() | coal.Capsule():
            turn = np.linspace(0.0, 2.0 * np.pi, _ROUND, endpoint=False)
            r = geometry.radius / np.cos(np.pi / _ROUND)
            ring = np.stack([r * np.cos(turn), r * np.sin(turn), np.zeros(_ROUND)], axis=1)
            half = geometry.halfLength
            half += geometry.radius if isinstance(geometry, coal.Capsule) else 0.0
            points = np.vstack([ring + np.array([0.0, 0.0, way * half]) for way in (1.0, -1.0)])
        case _:
            points = np.array(geometry.vertices(), dtype=float).reshape(-1, 3)
    return np.asarray(points @ pose.rotation.T + pose.translation)


def hull_around(points: Array) -> Geom:
    """A hull of not many corners that holds points (N, 3), in their frame."""
    try:
        corners = points[ConvexHull(points).vertices]
    except QhullError:  # they are flat
        points = (points[:, None] + _THIN * CORNERS).reshape(-1, 3)
        corners = points[ConvexHull(points).vertices]
    middle = corners.mean(axis=0)
    if len(corners) > _MOST:
        corners = _between_planes((corners @ _DIRECTIONS.T).max(axis=0), middle)
    return hull_of(middle + _WIDER * (corners - middle))


def _between_planes(supports: Array, inside: Array) -> Array:
    """Corners of the polyhedron between planes in all directions, by their distances from zero."""
    planes = np.column_stack([_DIRECTIONS, -supports])
    return np.asarray(HalfspaceIntersection(planes, inside).intersections)
