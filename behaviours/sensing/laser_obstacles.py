"""Laser obstacles: points that the laser has seen lately, whatever the map says."""

from collections import deque
from collections.abc import Sequence

import numpy as np

from behaviours.sensing.depth_obstacles import near
from controller import Array
from hw import LaserScan
from robots import Geom

_SCANS = 6  # that are kept
_CELL = 0.04  # side of a cell of the floor, of whose points the mean counts [m]
_LEAST = 3  # points of a cell that counts
_AROUND = 1.5  # points farther from the base are left out [m]


class LaserObstacles:
    """Keeps the points of the last scans in the world: one for every cell that was hit often."""

    def __init__(self) -> None:
        self._scans: deque[Array] = deque(maxlen=_SCANS)
        self._scan: LaserScan | None = None
        self.points = np.zeros((0, 3))
        """(N, 3) in the world [m]; another array when a scan comes."""

    def look(self, scan: LaserScan | None, moving: Sequence[Geom]) -> None:
        """Take the newest scan; what moves, in the world, is left out as it would leave a trail."""
        if scan is None or scan is self._scan:
            return
        self._scan = scan
        seen = scan.points[scan.ranges < _AROUND]
        points = seen @ scan.oTb.rotation.T + scan.oTb.translation
        self._scans.append(points[~near(points, moving)])
        every = np.concatenate(self._scans)
        cells = np.floor(every[:, :2] / _CELL).astype(np.int64)
        _, which, counts = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
        which = which.reshape(-1)
        sums = np.stack([np.bincount(which, axis, len(counts)) for axis in every.T], axis=1)
        self.points = (sums / counts[:, None])[counts >= _LEAST]
