"""Cells along x and y of the world, as seen from straight above."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from perception.frame import Array, Image, Indices, Mask

_HOLE = 3
"""Holes in a footprint that are not wider are none [cells]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Grid:
    """Cells along x and y of the world."""

    origin: Array
    """(2,) x and y of the centre of cell (0, 0) [m]."""
    shape: tuple[int, int]
    """(rows, columns); rows run along y, columns along x."""
    cell: float
    """Side of a cell [m]."""

    @classmethod
    def over(cls, points: Array, cell: float) -> Grid:
        """One that holds (N, 3) points."""
        low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
        columns, rows = np.rint((high - low) / cell).astype(int) + 1
        return cls(origin=low, shape=(int(rows), int(columns)), cell=cell)

    def cells_of(self, points: Array) -> tuple[Indices, Indices]:
        """Rows and columns (N,) of points."""
        column, row = np.rint((points[:, :2] - self.origin) / self.cell).astype(np.int64).T
        return row, column

    def heights(self, points: Array) -> Image:
        """(rows, columns) of the highest point of each cell [m]; 0 where there is none."""
        row, column = self.cells_of(points)
        upwards = np.argsort(points[:, 2], kind="stable")
        heights = np.zeros(self.shape, dtype=np.float32)
        heights[row[upwards], column[upwards]] = points[upwards, 2]
        return heights

    def covered(self, points: Array) -> Mask:
        """(rows, columns) which cells points lie in; small holes between them count too."""
        row, column = self.cells_of(points)
        cells = np.zeros(np.array(self.shape) + 2 * _HOLE, dtype=np.uint8)
        cells[row + _HOLE, column + _HOLE] = 1
        closed = cv2.morphologyEx(cells, cv2.MORPH_CLOSE, np.ones((_HOLE, _HOLE), np.uint8))
        mask: Mask = closed[_HOLE:-_HOLE, _HOLE:-_HOLE] > 0
        return mask

    def centres(self, cells: Mask) -> Array:
        """(N, 2) of cells, in the world [m]."""
        row, column = np.nonzero(cells)
        centres: Array = self.origin + self.cell * np.stack([column, row], axis=1)
        return centres
