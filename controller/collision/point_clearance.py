"""Distances from the robot to depth points.

Probes are places along the axes and on the faces of the robot's shapes. Each finds the depth point
nearest to it; the distance of that point is then measured from the shape itself.
"""

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np

from config.arrays import Array, Indices, Mask
from controller.collision.collision_model import CollisionModel, lines_along
from controller.surroundings import PointCloud
from robots import Box, Hull, Shape, from_rounded_boxes, rounded_box

_FACE = 0.4  # largest spacing of probes on the faces of boxes [m]
_MAX_POINTS = 2  # number of nearest points that are kept for one shape


class NearPoints(NamedTuple):
    """K depth points that are near shapes of the robot."""

    d: Array  # (K,) between point and shape [m]; negative inside
    lines: Array  # (K, 6) Plücker lines from shape to point: direction, moment about the origin
    shape: Indices  # (K,) indices of the shapes in the collision model
    kind: Indices  # (K,) `PairKind`


class PointClearance:
    """Tracks the distances of one robot's shapes to a point cloud."""

    def __init__(
        self, collision: CollisionModel, within: Callable[[Indices], Callable[[Array], Array]]
    ) -> None:
        """`within`: of kinds (F,), the function from speeds (F,) to distances that matter (F,)."""
        self._collision = collision
        bodies = collision.bodies
        rounded = [rounded_box(body.geom.shape) for body in bodies]
        self._half = np.array([half for half, _ in rounded])
        self._radius = np.array([radius for _, radius in rounded])
        places = [_places(body.geom.shape) for body in bodies]
        counts = [len(some) for some, _ in places]
        self._body = np.repeat(np.arange(len(bodies)), counts)
        self._places = np.concatenate([some for some, _ in places])  # (F, 3) in the shape's frame
        self._covers = np.repeat([covers for _, covers in places], counts)
        """(F,) a point may be nearer to the shape than to the probe by this much [m]."""
        self._shape = np.array([body.number for body in bodies])
        self._kind = np.array([body.kind for body in bodies], dtype=np.int64)[self._body]
        """(F,) `PairKind`."""
        self._within = within(self._kind)
        self._reach = collision.reach[self._shape][self._body]
        """(F, n) largest displacement of a point of the shape per degree of freedom [m/rad]."""
        self._cloud: PointCloud | None = None
        self._at_least = np.full(len(self._body), -np.inf)
        """(F,) lower bound of the distances of points that a probe finds to its shape [m]."""
        self._matters = self._at_least  # (F,) distance that matters now [m]

    def due(self, cloud: PointCloud, motion: Array) -> Indices | None:
        """The probes that may be near enough to a point to matter; None if none is.

        `motion` (n, 2) are the largest motion of every degree of freedom since the last call and
        its largest speed.
        """
        if cloud is not self._cloud:
            self._cloud, self._at_least = cloud, np.full(len(self._body), -np.inf)
        changes = self._reach @ motion
        self._at_least -= changes[:, 0]
        self._matters = self._within(changes[:, 1])
        (some,) = np.nonzero(self._at_least <= self._matters)
        return some if len(some) and len(cloud.points) else None

    def measure(self, some: Indices) -> NearPoints:
        """The nearest points found by probes (S,) of `due`, for the placed collision model."""
        cloud, body = self._cloud, self._body[some]
        assert cloud is not None
        R, origin = self._collision.poses(self._shape[body])
        places = (R @ self._places[some][:, :, None])[:, :, 0] + origin
        distances, found = cloud.nearest(places)
        self._at_least[some] = at_least = distances - self._covers[some]
        near = at_least <= self._matters[some]
        some, body, R, found = some[near], body[near], R[near], found[near]
        points = cloud.points[found]
        local = ((points - origin[near])[:, None, :] @ R)[:, 0]
        d, out = from_rounded_boxes(local, self._half[body], self._radius[body])
        kept = np.lexsort((found, d, body))
        kept = kept[d[kept] <= self._matters[some[kept]]]
        # Probes of one shape may find the same point.
        kept = kept[_differs(found[kept], 1) | _differs(body[kept], 1)]
        kept = kept[_differs(body[kept], _MAX_POINTS)]
        n, p = (R[kept] @ out[kept][:, :, None])[:, :, 0], points[kept]
        return NearPoints(
            d[kept], lines_along(n, p), self._shape[body[kept]], self._kind[some[kept]]
        )


def _differs(numbers: Indices, behind: int) -> Mask:
    """(K,) whether each is another number than the one so many places before."""
    another = np.ones(len(numbers), dtype=np.bool_)
    another[behind:] = numbers[behind:] != numbers[:-behind]
    return another


def _places(shape: Shape) -> tuple[Array, float]:
    """Probes (F, 3) in the frame of a shape, and the largest distance of its surface to one [m]."""
    half, radius = rounded_box(shape)
    apart = _FACE if isinstance(shape, Box | Hull) else 2.0 * radius
    counts = [int(np.ceil(2.0 * h / apart)) + 1 if h > apart / 10.0 else 1 for h in half]
    edges = list(zip(half.tolist(), counts, strict=True))
    lines = [np.linspace(-h, h, n) if n > 1 else np.zeros(1) for h, n in edges]
    places = np.array(list(product(*lines)))
    outer = (np.abs(places) >= half - 1e-9).any(axis=1) | (min(counts) == 1)
    beside = [h / max(n - 1, 1) for h, n in edges]
    return places[outer], radius + float(np.linalg.norm(beside))
