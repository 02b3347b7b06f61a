"""A region seen from straight above, put together from several depth frames."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

from behaviours.poses import Region
from behaviours.settings import OccupancySettings
from hw import DepthFrame
from perception import OCCUPIED_HEIGHT, WALL_MARGIN, world_points


class Segment(NamedTuple):
    """What stands by itself in the region, seen from above."""

    centre: npt.NDArray[np.float64]
    """(3,) on the floor of the region, in the world [m]."""
    area: float
    """Seen from above [m^2]."""


class Occupancy:
    """What stands in a region, as most of the frames show that see a cell of it.

    Args:
        region: its floor is what objects stand on; along its sides it is left out, as there may be
            walls.
        settings: how finely it is looked at.
    """

    def __init__(self, region: Region, settings: OccupancySettings) -> None:
        self._region = region
        self._settings = settings
        self._cell = settings.cell
        self._half = region.size[:2] / 2.0 - WALL_MARGIN
        shape = np.maximum(np.ceil(2.0 * self._half / self._cell).astype(int), 1)
        self._seen = np.zeros(shape, dtype=np.int32)
        self._occupied = np.zeros(shape, dtype=np.int32)

    def add(self, frame: DepthFrame) -> None:
        """Take in a frame."""
        rows, columns = frame.depth.shape
        every = self._settings.stride
        depth = frame.depth[::every, ::every]
        points = world_points(
            depth,
            frame.intrinsics,
            frame.wTc,
            np.arange(columns, dtype=float)[None, ::every],
            np.arange(rows, dtype=float)[::every, None],
        )
        region = self._region
        local = (points[np.isfinite(depth)] - region.wTr.translation) @ region.wTr.rotation
        x, y, height = local[:, 0], local[:, 1], local[:, 2] + region.size[2] / 2.0
        inside = (np.abs(x) < self._half[0]) & (np.abs(y) < self._half[1])
        inside &= (height > -self._settings.below) & (height < region.size[2])
        cells = ((local[inside, :2] + self._half) / self._cell).astype(int)
        seen, occupied = np.zeros_like(self._seen), np.zeros_like(self._seen)
        seen[cells[:, 0], cells[:, 1]] = 1
        high = cells[height[inside] > OCCUPIED_HEIGHT]
        occupied[high[:, 0], high[:, 1]] = 1
        self._seen += seen
        self._occupied += occupied

    @property
    def seen(self) -> float:
        """Share of the region that was seen, 0 to 1."""
        return float((self._seen > 0).mean())

    def segments(self, smallest: float) -> list[Segment]:
        """Everything that stands by itself and covers at least an area [m^2]."""
        occupied = (2 * self._occupied > self._seen).astype(np.uint8)
        opened = cv2.morphologyEx(occupied, cv2.MORPH_OPEN, np.ones((2, 2), np.uint8))
        count, _, stats, centres = cv2.connectedComponentsWithStats(opened, connectivity=4)
        return [
            Segment(centre=self._world(centres[i]), area=area)
            for i in range(1, count)
            if (area := float(stats[i, cv2.CC_STAT_AREA]) * self._cell**2) >= smallest
        ]

    def _world(self, centre: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        column, row = centre  # OpenCV's x runs along the second axis
        x, y = np.array([row, column]) * self._cell + self._cell / 2.0 - self._half
        centre_r = np.array([x, y, -self._region.size[2] / 2.0])
        return np.asarray(self._region.wTr.act(centre_r))
