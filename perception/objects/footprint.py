"""Which part of the floor something covers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from perception.frame import Array, Mask
from perception.objects.grid import Grid


@dataclass(frozen=True, kw_only=True, eq=False)
class Footprint:
    """Where something stands, seen from above: cells of a grid along x and y of the world."""

    cells: Mask
    """(rows, columns); rows run along y, columns along x."""
    origin: Array
    """(2,) x and y of the centre of cell (0, 0) [m]."""
    cell: float
    """Side of a cell [m]."""

    def area_near(self, other: Footprint, distance: float) -> float:
        """Area of that part of it that is nearer than a distance [m] to another one [m^2]."""
        from scipy.spatial import cKDTree

        gaps, _ = cKDTree(other._centres()).query(self._centres())
        return float(np.count_nonzero(gaps < distance) * self.cell**2)

    def shared(self, other: Footprint) -> float:
        """The share of what each of the two covers that the other one covers too; the less."""
        ours, theirs = other.holds(*self._centres().T), self.holds(*other._centres().T)
        return float(min(ours.mean(), theirs.mean()))

    def _centres(self) -> Array:
        """(N, 2) of its cells, in the world [m]."""
        rows, columns = self.cells.shape
        grid = Grid(origin=self.origin, shape=(rows, columns), cell=self.cell)
        return grid.centres(self.cells)

    def holds(self, x: Array, y: Array) -> Mask:
        """(N,) whether it covers points of the world [m]."""
        column = np.rint((x - self.origin[0]) / self.cell).astype(np.int64)
        row = np.rint((y - self.origin[1]) / self.cell).astype(np.int64)
        rows, columns = self.cells.shape
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        held: Mask = np.zeros(len(inside), dtype=np.bool_)
        held[inside] = self.cells[row[inside], column[inside]]
        return held
