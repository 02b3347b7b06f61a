"""Grids along x and y in odometry, seen from above, and the footprints of objects on them."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from config.arrays import Array, Image, Indices, Mask

_HOLE = 3  # width of holes in a footprint that are closed [cells]


@dataclass(frozen=True, kw_only=True, eq=False)
class Grid:
    """Cells along x and y in odometry."""

    origin: Array  # (2,) x and y of the centre of cell (0, 0) [m]
    shape: tuple[int, int]  # (rows, columns); rows run along y, columns along x
    cell: float  # side of a cell [m]

    @classmethod
    def over(cls, points: Array, cell: float) -> Grid:
        """The grid that holds (N, 3) points."""
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
        """(N, 2) of cells, in odometry [m]."""
        row, column = np.nonzero(cells)
        centres: Array = self.origin + self.cell * np.stack([column, row], axis=1)
        return centres


@dataclass(frozen=True, kw_only=True, eq=False)
class Footprint:
    """Cells along x and y in odometry that an object covers."""

    cells: Mask  # (rows, columns); rows run along y, columns along x
    origin: Array  # (2,) x and y of the centre of cell (0, 0) [m]
    cell: float  # side of a cell [m]

    def area_near(self, other: Footprint, distance: float) -> float:
        """Area of its part that is nearer than a distance [m] to another one [m^2]."""
        from scipy.spatial import cKDTree

        gaps, _ = cKDTree(other._centres()).query(self._centres())
        return float(np.count_nonzero(gaps < distance) * self.cell**2)

    def shared(self, other: Footprint) -> float:
        """The smaller share of both areas that the other one covers."""
        ours, theirs = other.holds(*self._centres().T), self.holds(*other._centres().T)
        return float(min(ours.mean(), theirs.mean()))

    def _centres(self) -> Array:
        """(N, 2) of its cells, in odometry [m]."""
        rows, columns = self.cells.shape
        grid = Grid(origin=self.origin, shape=(rows, columns), cell=self.cell)
        return grid.centres(self.cells)

    def holds(self, x: Array, y: Array) -> Mask:
        """(N,) whether it covers points in odometry [m]."""
        column = np.rint((x - self.origin[0]) / self.cell).astype(np.int64)
        row = np.rint((y - self.origin[1]) / self.cell).astype(np.int64)
        rows, columns = self.cells.shape
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        held: Mask = np.zeros(len(inside), dtype=np.bool_)
        held[inside] = self.cells[row[inside], column[inside]]
        return held
