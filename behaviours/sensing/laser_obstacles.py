"""The newest scan that can be believed, and the points that scans have shown lately."""

from collections import deque
from collections.abc import Sequence

import numpy as np

from behaviours.sensing.depth_obstacles import near
from config.arrays import Array
from hw import Laser, LaserScan
from robots import Geom

_AGE = 0.3  # an older scan, or one whose ranges are older, tells nothing [s]
_FEWEST = 10  # beams that come back, of which noise changes one from scan to scan
_NOISY = 0.3  # share of the beams that noise alone changes
_STILL, _MOVED = 1e-4, 0.03  # a base that moves less stands still, or more sees something else
_SCANS = 6  # that are kept
_CELL = 0.04  # side of a cell of the floor, of whose points the mean counts [m]
_LEAST = 3  # points of a cell that counts
_AROUND = 1.5  # points farther from the base are left out [m]


class Scans:
    """The scans of one laser, without those that repeat an earlier one, as of a driver that hangs.

    A scan is as old as the first with the same ranges, where noise or motion should change them.
    """

    def __init__(self) -> None:
        self._newest: LaserScan | None = None
        self._first: LaserScan | None = None  # with its ranges
        self._is_noisy = False
        self.mistake = ""
        """Why the newest scan is not believed; empty if it is."""

    def newest(self, laser: Laser) -> LaserScan | None:
        """The newest scan; None if there is none to believe."""
        scan = laser.latest(_AGE)
        if scan is not None and scan is not self._newest:
            self._newest, first = scan, self._first
            same = first is not None and np.array_equal(first.ranges, scan.ranges, equal_nan=True)
            if first is None or not same:
                self._is_noisy = self._is_noisy or (first is not None and _is_noise(first, scan))
                self._first = first = scan
            hangs = (
                scan.stamp - first.stamp > _AGE
                and np.isfinite(scan.ranges).sum() >= _FEWEST
                and (self._is_noisy or _way(first, scan) > _MOVED)
            )
            self.mistake = "the scan does not change: the laser hangs" if hangs else ""
        return None if self.mistake else scan


def _is_noise(before: LaserScan, scan: LaserScan) -> bool:
    """Whether two scans differ nearly everywhere though the base has not moved."""
    if before.ranges.shape != scan.ranges.shape or _way(before, scan) > _STILL:
        return False
    both = np.isfinite(before.ranges) & np.isfinite(scan.ranges)
    changed = before.ranges[both] != scan.ranges[both]
    return len(changed) >= _FEWEST and bool(changed.mean() > _NOISY)


def _way(before: LaserScan, scan: LaserScan) -> float:
    return float(np.abs(before.oTb.homogeneous - scan.oTb.homogeneous).max())


class LaserObstacles:
    """Keeps the points of the last scans in odometry: one for every cell that was hit often."""

    def __init__(self) -> None:
        self._scans: deque[Array] = deque(maxlen=_SCANS)
        self._scan: LaserScan | None = None
        self.points = np.zeros((0, 3))
        """(N, 3) in odometry [m]; another array when a scan comes."""

    def look(self, scan: LaserScan | None, moving: Sequence[Geom]) -> None:
        """Take the newest scan; what moves, in odometry, is left out as it would leave a trail."""
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
