"""How high the scene is, seen from straight above, on a regular grid of the world."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from pinocchio import SE3

from perception.arrays import Array, Image
from perception.frame import Intrinsics
from perception.preprocess import fill

CELL = 0.0015
"""Side of a cell [m]."""
REACH = 0.36
"""Points farther than this from the camera, along x or y of the world, are left out [m]."""


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
        """Heights at world positions of any shape [m]; outside the grid those of its rim."""
        return look_up(self.heights, self.origin, self.cell, x, y)


def look_up(values: Image, origin: Array, cell: float, x: Array | Image, y: Array | Image) -> Image:
    """Values of the cells at world positions [m]; outside the grid those of its rim."""
    rows, columns = values.shape
    # Half a cell is added so that cutting off rounds to the nearest.
    column = (x - (origin[0] - 0.5 * cell)) * (1.0 / cell)
    row = (y - (origin[1] - 0.5 * cell)) * (1.0 / cell)
    column = np.clip(column, 0, columns - 1).astype(np.int32)
    row = np.clip(row, 0, rows - 1).astype(np.int32)
    found: Image = values.ravel().take(row * np.int32(columns) + column)
    return found


def world_points(
    depth: Image,
    intrinsics: Intrinsics,
    wTc: SE3,
    u: Array,
    v: Array,
) -> Array:
    """World points of pixels.

    Args:
        depth: depth along the optical axis of each pixel, any shape [m].
        intrinsics: the camera's pinhole model.
        wTc: camera in the world.
        u: columns in the full image, shaped like `depth` or broadcast to it [px].
        v: rows in the full image, likewise [px].

    Returns:
        (..., 3) points [m]; NaN where the depth is.
    """
    z = depth.astype(float)
    x = (u - intrinsics.cx) / intrinsics.fx * z
    y = (v - intrinsics.cy) / intrinsics.fy * z
    points: Array = np.stack([x, y, z], axis=-1) @ wTc.rotation.T + wTc.translation
    return points


def height_map(points: Array, wTc: SE3) -> HeightMap:
    """The upper surface of measured points.

    What nothing was measured of lies hidden behind something higher, so it takes the lower of its
    two neighbours in the row. A small median then takes single wrong points away.

    Args:
        points: (..., 3) world points, all finite [m].
        wTc: where they were seen from.
    """
    x, y, z = np.ascontiguousarray(points.reshape(-1, 3).T)
    near = np.abs(x - wTc.translation[0]) < REACH
    near &= np.abs(y - wTc.translation[1]) < REACH
    if near.any():
        x, y, z = x[near], y[near], z[near]
    else:
        x, y, z = x[:1], y[:1], z[:1]
    origin = np.array([x.min(), y.min()])
    column = np.rint((x - origin[0]) / CELL).astype(np.int64)
    row = np.rint((y - origin[1]) / CELL).astype(np.int64)
    shape = (int(row.max()) + 1, int(column.max()) + 1)
    heights = np.full(shape, -np.inf, dtype=np.float32)
    np.maximum.at(heights.ravel(), row * shape[1] + column, z.astype(np.float32))
    heights = -fill(-heights, np.isinf(heights))
    return HeightMap(
        heights=np.asarray(cv2.medianBlur(heights, 3), dtype=np.float32), origin=origin
    )
