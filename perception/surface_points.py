"""From depth frames to points of surfaces that are really there, remembered for a while.

Points are collected in the cells of a grid. A cell counts when it was hit twice, so that no single
wrong pixel becomes an obstacle. It is emptied when the camera sees what is behind it, and forgotten
some time after it was seen last.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from perception.arrays import Array
from perception.frame import Frame
from perception.geometry import Camera, world_points


@dataclass(frozen=True, kw_only=True)
class SurfaceSettings:
    """What is believed, and for how long."""

    stride: int = 8
    """Only every n-th pixel is used, along rows and columns."""
    farthest: float = 2.0
    """Depths beyond this are too noisy [m]."""
    neighbour: int = 2
    """A point needs neighbours this far beside it [px] ..."""
    slope: float = 0.03
    """... whose depths differ by no more than this, per depth."""
    floor: float = 0.06
    """What is lower than this is taken for the floor [m]."""
    cell: float = 0.03
    """Side of a cell [m]."""
    least_hits: int = 2
    """A cell that was hit less often counts for nothing ..."""
    doubtful: float = 1.0
    """... and is forgotten this long after the hit [s]."""
    most_hits: int = 8
    """More hits make a cell no more certain."""
    seen_through: int = 2
    """Hits that a cell loses in every frame that sees what is behind it."""
    behind: float = 0.03
    """What is seen is behind a cell if it is farther away by more than this, and by more than the
    noise [m]."""
    memory: float = 20.0
    """A cell is forgotten this long after it was seen last [s]."""
    around: float = 2.0
    """Cells that are farther than this from the camera, seen from above, are forgotten [m]."""


_NOISE = 0.015
"""Three standard deviations of the depth at 1 m; they grow with its square [m]."""


def surface_points(frame: Frame, settings: SurfaceSettings) -> Array:
    """Points (N, 3) in the world that a frame shows, without the floor [m].

    At the edge of a surface a depth camera sees things that are not there: between near and far.
    A point counts only if at least three of the four beside it are about as far away.
    """
    s, depth, n = settings, frame.depth, settings.neighbour
    rows, columns = depth.shape
    v = np.arange(s.stride // 2, rows - n, s.stride)
    u = np.arange(s.stride // 2, columns - n, s.stride)
    here = depth[np.ix_(v, u)]
    most = s.slope * here
    agree = np.zeros(here.shape, dtype=np.int8)
    for dv, du in ((-n, 0), (n, 0), (0, -n), (0, n)):
        agree += np.abs(depth[np.ix_(v + dv, u + du)] - here) <= most
    j, i = np.nonzero((agree >= 3) & (here <= s.farthest))
    points = world_points(here[j, i], frame.intrinsics, frame.wTc, u[i], v[j])
    return points[points[:, 2] > s.floor]


class SeenSurfaces:
    """What was seen around the robot lately.

    Args:
        settings: what is believed, and for how long.
    """

    def __init__(self, settings: SurfaceSettings) -> None:
        self._settings = settings
        self._keys = np.zeros(0, dtype=np.int64)
        self._points = np.zeros((0, 3))
        self._hits = np.zeros(0, dtype=np.int64)
        self._stamps = np.zeros(0)

    @property
    def points(self) -> Array:
        """(N, 3) in the world, one for every cell in which there is something [m]."""
        return self._points[self._hits >= self._settings.least_hits]

    def keep(self, kept: npt.NDArray[np.bool_]) -> None:
        """Forget all other cells, (N,) in the order of `all_points`."""
        self._keys, self._points = self._keys[kept], self._points[kept]
        self._hits, self._stamps = self._hits[kept], self._stamps[kept]

    @property
    def all_points(self) -> Array:
        """(N, 3) one for every cell, doubtful ones included [m]."""
        return self._points

    def update(self, frame: Frame, points: Array) -> None:
        """Take a newer frame.

        Args:
            frame: what was seen; empties cells.
            points: (N, 3) what of it fills cells, in the world [m].
        """
        s = self._settings
        self._hits -= s.seen_through * self._seen_through(frame)
        age = frame.stamp - self._stamps
        away = np.abs(self._points[:, :2] - frame.wTc.translation[:2]).max(axis=1, initial=0.0)
        lasts = np.where(self._hits >= s.least_hits, s.memory, s.doubtful)
        self.keep((self._hits > 0) & (age <= lasts) & (away <= s.around))
        self._add(points, frame.stamp)

    def _seen_through(self, frame: Frame) -> npt.NDArray[np.bool_]:
        """Cells whose pixel, and those around it, show something farther away."""
        s = self._settings
        z = (self._points - frame.wTc.translation) @ frame.wTc.rotation[:, 2]
        through = np.zeros(len(z), dtype=bool)
        (ahead,) = np.nonzero(z > s.behind)
        pixels = Camera(intrinsics=frame.intrinsics, wTc=frame.wTc).project(self._points[ahead])
        u, v = np.rint(pixels).astype(np.int64).T
        rows, columns = frame.depth.shape
        n = s.neighbour
        inside = (u >= n) & (u < columns - n) & (v >= n) & (v < rows - n)
        u, v, ahead = u[inside], v[inside], ahead[inside]
        least = z[ahead] + s.behind + _NOISE * z[ahead] ** 2
        beyond = [
            frame.depth[v + dv, u + du] > least
            for dv, du in ((0, 0), (-n, 0), (n, 0), (0, -n), (0, n))
        ]
        through[ahead] = np.all(beyond, axis=0)
        return through

    def _add(self, points: Array, stamp: float) -> None:
        s = self._settings
        if not len(points):
            return
        i, j, k = np.floor(points / s.cell).astype(np.int64).T + _OFFSET
        keys, which, counts = np.unique(
            (i << 42) + (j << 21) + k, return_inverse=True, return_counts=True
        )
        means = np.stack([np.bincount(which, axis) for axis in points.T], axis=1) / counts[:, None]
        at = np.searchsorted(self._keys, keys)
        known = at < len(self._keys)
        known[known] = self._keys[at[known]] == keys[known]
        at = at[known]
        hits = np.minimum(self._hits[at] + counts[known], s.most_hits)
        share = np.minimum(counts[known] / hits, 1.0)[:, None]
        self._points[at] += share * (means[known] - self._points[at])
        self._hits[at], self._stamps[at] = hits, stamp
        new = ~known
        keys = np.concatenate([self._keys, keys[new]])
        order = np.argsort(keys, kind="stable")
        self._keys = keys[order]
        self._points = np.concatenate([self._points, means[new]])[order]
        self._hits = np.concatenate([self._hits, np.minimum(counts[new], s.most_hits)])[order]
        self._stamps = np.concatenate([self._stamps, np.full(int(new.sum()), stamp)])[order]


_OFFSET = 1 << 20
"""Makes the numbers of cells positive."""
