"""Points of surfaces in depth frames, accumulated in a voxel grid with a limited memory.

A cell counts when it was hit twice, so that no single wrong pixel becomes an obstacle. It is
cleared when the camera sees what is behind it, and forgotten some time after it was seen last
unless near.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from config.arrays import Array, Indices, Mask
from perception.frame import Frame
from perception.geometry import Camera

_STRIDE = 8  # only every n-th pixel is used, along rows and columns
_FARTHEST = 2.0  # larger depths are too noisy [m]
_NEIGHBOUR = 2  # a point needs neighbours this far beside it [px] ...
_SLOPE = 0.03  # ... whose depths differ by at most this share
_FLOOR = 0.06  # lower points belong to the floor [m]
_CELL = 0.03  # side of a cell [m]
_LEAST_HITS = 2  # of a cell that counts ...
_DOUBTFUL = 1.0  # ... others are forgotten this long after the hit [s]
_MOST_HITS = 8  # further hits make a cell no more certain
_SEEN_THROUGH = 2  # hits that a cell loses in a frame that sees behind it
_BEHIND = 0.03  # least distance of what is seen behind a cell, noise apart [m]
MEMORY = 20.0  # a cell is forgotten this long after it was seen last [s] ...
_NEAR = 1.3  # ... unless it is horizontally nearer than this to the camera [m]
_AROUND = 2.0  # cells farther away are forgotten at once [m]
_NOISE = 0.015  # three standard deviations of the depth at 1 m; they grow with its square [m]
_OFFSET = 1 << 20  # makes the numbers of cells positive


class Cells(NamedTuple):
    """N cells of a grid in odometry, in order."""

    keys: Indices  # (N,) ascending
    points: Array  # (N, 3) mean of the points in each cell, in odometry [m]
    hits: Indices  # (N,) number of hits

    def of(self, kept: Mask) -> Cells:
        """Some of them."""
        return Cells(self.keys[kept], self.points[kept], self.hits[kept])


def surface_cells(frame: Frame) -> Cells:
    """Cells with surfaces in a frame, without the floor.

    At the edge of a surface a depth camera measures points between near and far. A point counts
    only if at least three of its four neighbours are about as far away.
    """
    depth, n = frame.depth, _NEIGHBOUR
    rows, columns = depth.shape
    v = np.arange(_STRIDE // 2, rows - n, _STRIDE)
    u = np.arange(_STRIDE // 2, columns - n, _STRIDE)
    here = depth[np.ix_(v, u)]
    most = _SLOPE * here
    agree = np.zeros(here.shape, dtype=np.int8)
    for dv, du in ((-n, 0), (n, 0), (0, -n), (0, n)):
        agree += np.abs(depth[np.ix_(v + dv, u + du)] - here) <= most
    j, i = np.nonzero((agree >= 3) & (here <= _FARTHEST))
    points = frame.cloud.points(v[j], u[i])
    points = points[points[:, 2] > _FLOOR]
    x, y, z = np.floor(points / _CELL).astype(np.int64).T + _OFFSET
    keys, which, hits = np.unique(
        (x << 42) + (y << 21) + z, return_inverse=True, return_counts=True
    )
    sums = [np.bincount(which, axis, len(keys)) for axis in points.T]
    return Cells(keys, np.stack(sums, axis=1) / hits[:, None], hits)


class SurfaceGrid:
    """Surfaces seen around the robot lately."""

    def __init__(self) -> None:
        self._keys = np.zeros(0, dtype=np.int64)
        self._points = np.zeros((0, 3))
        self._hits = np.zeros(0, dtype=np.int64)
        self._stamps = np.zeros(0)

    @property
    def points(self) -> Array:
        """(N, 3) in odometry, one for every cell that counts [m]."""
        return self._points[self._hits >= _LEAST_HITS]

    def keep(self, kept: Mask) -> None:
        """Forget all other cells, (N,) in the order of `all_points`."""
        self._keys, self._points = self._keys[kept], self._points[kept]
        self._hits, self._stamps = self._hits[kept], self._stamps[kept]

    @property
    def all_points(self) -> Array:
        """(N, 3) one for every cell, doubtful ones included [m]."""
        return self._points

    def update(self, frame: Frame, seen: Cells) -> None:
        """Let a newer frame clear cells, and its `surface_cells` fill others."""
        self._hits -= _SEEN_THROUGH * self._seen_through(frame)
        age = frame.stamp - self._stamps
        away = np.abs(self._points[:, :2] - frame.oTc.translation[:2]).max(axis=1, initial=0.0)
        certain = self._hits >= _LEAST_HITS
        lasts = np.where(certain, np.where(away <= _NEAR, np.inf, MEMORY), _DOUBTFUL)
        self.keep((self._hits > 0) & (age <= lasts) & (away <= _AROUND))
        self._add(seen, frame.stamp)

    def _seen_through(self, frame: Frame) -> Mask:
        """Cells whose pixel, and those around it, show something farther away."""
        z = (self._points - frame.oTc.translation) @ frame.oTc.rotation[:, 2]
        through = np.zeros(len(z), dtype=bool)
        (ahead,) = np.nonzero(z > _BEHIND)
        pixels = Camera(intrinsics=frame.intrinsics, oTc=frame.oTc).project(self._points[ahead])
        u, v = np.rint(pixels).astype(np.int64).T
        rows, columns = frame.depth.shape
        n = _NEIGHBOUR
        inside = (u >= n) & (u < columns - n) & (v >= n) & (v < rows - n)
        u, v, ahead = u[inside], v[inside], ahead[inside]
        least = z[ahead] + _BEHIND + _NOISE * z[ahead] ** 2
        beyond = [
            frame.depth[v + dv, u + du] > least
            for dv, du in ((0, 0), (-n, 0), (n, 0), (0, -n), (0, n))
        ]
        through[ahead] = np.all(beyond, axis=0)
        return through

    def _add(self, seen: Cells, stamp: float) -> None:
        at = np.searchsorted(self._keys, seen.keys)
        known = at < len(self._keys)
        known[known] = self._keys[at[known]] == seen.keys[known]
        at, old, new, most = at[known], seen.of(known), seen.of(~known), _MOST_HITS
        hits = np.minimum(self._hits[at] + old.hits, most)
        share = np.minimum(old.hits / hits, 1.0)[:, None]
        self._points[at] += share * (old.points - self._points[at])
        self._hits[at], self._stamps[at] = hits, stamp
        keys = np.concatenate([self._keys, new.keys])
        order = np.argsort(keys, kind="stable")
        self._keys = keys[order]
        self._points = np.concatenate([self._points, new.points])[order]
        self._hits = np.concatenate([self._hits, np.minimum(new.hits, most)])[order]
        self._stamps = np.concatenate([self._stamps, np.full(len(new.keys), stamp)])[order]
