"""Capsules around point sets and geometries: never tighter than what they stand for."""

from __future__ import annotations

from contextlib import suppress
from typing import Any, NamedTuple

import coal
import numpy as np
from pinocchio import SE3, Quaternion
from scipy.spatial import ConvexHull, QhullError

from robots.shapes import Array

_ROUND = 32  # corners of a circle
_WIDER = np.linspace(1.0, 1.4, 9)  # radii that are tried: a wider capsule may be shorter
_SPLITS = 2  # how often a shape is cut in two ...
_WORTH = 0.85  # ... where that leaves at most this share of the volume
_MANY, _MOST_PIECES = 60, 6000  # points from which their hull is taken, triangles that are cut
_MARGIN = 1e-4  # for the digits of the file [m]


class CapsuleFit(NamedTuple):
    """A capsule in the frame of its points."""

    centre: Array  # (3,)
    axis: Array  # (3,) unit vector
    radius: float
    length: float  # between the centres of the half balls [m]

    @property
    def volume(self) -> float:
        """In m³."""
        return float(np.pi * self.radius**2 * (self.length + 4.0 / 3.0 * self.radius))

    def moved(self, aTb: SE3) -> CapsuleFit:
        """The same seen from frame a, its points being in frame b."""
        return self._replace(centre=aTb.act(self.centre), axis=aTb.rotation @ self.axis)

    @property
    def pose(self) -> SE3:
        """Of a capsule along z."""
        return SE3(Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), self.axis), self.centre)


def points_of(geometry: Any) -> tuple[Array, list[Array]]:
    """Points (N, 3) whose hull holds a geometry of Coal, and the parts into which it may be cut.

    A part is the (k, 3) points of one convex piece: a triangle of a mesh, or all of a primitive.
    """
    match geometry:
        case coal.Box():
            signs = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T
            points = signs * geometry.halfSide
        case coal.Sphere():
            points = np.vstack([np.eye(3), -np.eye(3)]) * geometry.radius
        case coal.Cylinder() | coal.Capsule():
            turn = np.linspace(0.0, 2.0 * np.pi, _ROUND, endpoint=False)
            r = geometry.radius / np.cos(np.pi / _ROUND)
            ring = np.stack([r * np.cos(turn), r * np.sin(turn), np.zeros(_ROUND)], axis=1)
            half = geometry.halfLength
            half += geometry.radius if isinstance(geometry, coal.Capsule) else 0.0
            points = np.vstack([ring + np.array([0.0, 0.0, way * half]) for way in (1.0, -1.0)])
        case _:
            points = np.array(geometry.vertices(), dtype=float).reshape(-1, 3)
            if geometry.num_tris > _MOST_PIECES:
                return points, [points]
            faces = map(geometry.tri_indices, range(geometry.num_tris))
            corners = np.array([[face[0], face[1], face[2]] for face in faces], int).reshape(-1, 3)
            return points, list(points[corners])
    return points, [points]


def placed_points(geometry: Any, pose: SE3) -> Array:
    """Points (N, 3) whose hull holds a geometry at a pose."""
    return np.asarray(points_of(geometry)[0] @ pose.rotation.T + pose.translation)


def capsules_around(geometry: Any, pose: SE3) -> list[CapsuleFit]:
    """Capsules that hold all of a geometry at a pose."""
    if isinstance(geometry, coal.Sphere):
        return [CapsuleFit(pose.translation, np.array([0.0, 0.0, 1.0]), geometry.radius, 0.0)]
    points, parts = points_of(geometry)
    points = points @ pose.rotation.T + pose.translation
    if len(parts) < 4:
        return [] if not len(points) else [capsule_around(points)]
    pieces = np.array(parts) @ pose.rotation.T + pose.translation
    return _cut(pieces, _SPLITS)


def _cut(pieces: Array, splits: int) -> list[CapsuleFit]:
    """Capsules around triangles (N, 3, 3), in two halves along the longest axis where worth it."""
    whole = capsule_around(pieces.reshape(-1, 3))
    if not splits or len(pieces) < 8:
        return [whole]
    along = (pieces.mean(axis=1) - whole.centre) @ whole.axis
    best = [whole]
    for where in np.quantile(along, (0.25, 0.5, 0.75)):
        halves = [pieces[along <= where], pieces[along > where]]
        if min(map(len, halves)) < 4:
            continue
        some = [capsule_around(half.reshape(-1, 3)) for half in halves]
        if sum(one.volume for one in some) < min(
            _WORTH * whole.volume, sum(one.volume for one in best)
        ):
            best = [one for half in halves for one in _cut(half, splits - 1)]
    return best


def capsule_around(points: Array) -> CapsuleFit:
    """The smallest capsule around points (N, 3) along their main or coordinate axes."""
    if len(points) > _MANY:
        with suppress(QhullError):  # they are flat
            points = points[ConvexHull(points).vertices]
    middle = points.mean(axis=0)
    main = np.linalg.svd(points - middle, full_matrices=False)[2] if len(points) > 2 else np.eye(3)
    return min((_along(points, axis) for axis in (*main, *np.eye(3))), key=lambda one: one.volume)


def _along(points: Array, axis: Array) -> CapsuleFit:
    axis = axis / np.linalg.norm(axis)
    side = np.linalg.svd(axis[None])[2][1:]  # two directions across it
    flat = points @ side.T
    centre = _circle_centre(flat)
    away = np.linalg.norm(flat - centre, axis=1)
    along = points @ axis
    best: CapsuleFit | None = None
    for radius in float(away.max()) * _WIDER + _MARGIN:
        cap = np.sqrt(np.maximum(radius**2 - away**2, 0.0))
        low, high = float((along + cap).min()), float((along - cap).max())
        middle, length = (low + high) / 2.0, max(0.0, high - low)
        where = centre @ side + middle * axis
        if length == 0.0:  # a ball: it must hold the farthest point
            radius = float(np.linalg.norm(points - where, axis=1).max()) + _MARGIN
        one = CapsuleFit(where, axis, float(radius), length)
        best = one if best is None or one.volume < best.volume else best
    assert best is not None
    return best


def _circle_centre(flat: Array) -> Array:
    """About the centre of the smallest circle around points (N, 2)."""
    centre = (flat.min(axis=0) + flat.max(axis=0)) / 2.0
    for step in 0.5 ** np.arange(1, 40):  # towards the farthest point, by less and less
        away = flat - centre
        centre = centre + 0.2 * step**0.5 * away[np.argmax((away**2).sum(axis=1))]
    return np.asarray(centre)
