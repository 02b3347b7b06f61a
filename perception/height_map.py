"""A height map of the scene: its upper surface on a regular grid of the world."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from pinocchio import SE3

from perception.arrays import Array, Image
from perception.geometry import world_maps
from perception.preprocess import fill
from robots import Intrinsics

CELL = 0.0015
"""Side of a cell [m]."""
MAX_OFFSET = 0.36
"""Points farther than this from the camera along x or y of the world are left out, which bounds the
size of the map [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class HeightMap:
    """Heights on a grid whose rows run along y of the world and columns along x."""

    heights: Image
    """(rows, columns) height in the world [m]."""
    origin: Array
    """(2,) x and y of the centre of cell (0, 0) [m]."""
    cell: float = CELL
    """Side of a cell [m]."""

    def at(self, x: Array | Image, y: Array | Image) -> Image:
        """Heights at world positions of any shape [m]; outside the grid, those of its border."""
        return look_up(self.heights, self.origin, self.cell, x, y)


def look_up(values: Image, origin: Array, cell: float, x: Array | Image, y: Array | Image) -> Image:
    """Values of the cells at world positions [m]; outside the grid, those of its border."""
    rows, columns = values.shape
    # Half a cell is added so that truncation rounds to the nearest.
    column = (x - (origin[0] - 0.5 * cell)) * (1.0 / cell)
    row = (y - (origin[1] - 0.5 * cell)) * (1.0 / cell)
    column = np.clip(column, 0, columns - 1).astype(np.int32)
    row = np.clip(row, 0, rows - 1).astype(np.int32)
    found: Image = values.ravel().take(row * np.int32(columns) + column)
    return found


def build_height_map(
    depth: Image, intrinsics: Intrinsics, wTc: SE3, u: Array, v: Array
) -> HeightMap:
    """The upper surface of a depth image.

    A cell without a point is hidden behind something higher, so it takes the lower of its two
    neighbours in the row. A 3x3 median then removes single outliers.

    Args:
        depth: (H, W) without holes [m].
        intrinsics: the camera's pinhole model.
        wTc: camera in the world.
        u: (1, W) columns in the full image [px].
        v: (H, 1) rows in the full image [px].
    """
    # Relative to the camera, single precision is exact to a micrometre.
    here = SE3(wTc.rotation, np.array([0.0, 0.0, wTc.translation[2]]))
    x, y, z = (each.ravel() for each in world_maps(depth, intrinsics, here, u, v))
    near = (np.abs(x) < MAX_OFFSET) & (np.abs(y) < MAX_OFFSET)
    if not near.any():
        near[0] = True
    if not near.all():
        x, y, z = x[near], y[near], z[near]
    first_x, first_y = x.min(), y.min()
    column = ((x - first_x) * np.float32(1.0 / CELL) + np.float32(0.5)).astype(np.int32)
    row = ((y - first_y) * np.float32(1.0 / CELL) + np.float32(0.5)).astype(np.int32)
    shape = (int(row.max()) + 1, int(column.max()) + 1)
    heights = np.full(shape, -np.inf, dtype=np.float32)
    np.maximum.at(heights.ravel(), row * np.int32(shape[1]) + column, z)
    heights = -fill(-heights, np.isinf(heights))
    return HeightMap(
        heights=np.asarray(cv2.medianBlur(heights, 3), dtype=np.float32),
        origin=np.array([first_x, first_y], dtype=float) + wTc.translation[:2],
    )
