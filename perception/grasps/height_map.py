"""A height map of the scene: its upper surface on a regular grid of the world."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from pinocchio import SE3

from perception.frame import Array, Image, Indices, Mask
from perception.geometry import world_maps
from perception.grasps.network_input import fill
from perception.grasps.stereo import Occlusion
from robots import Intrinsics

CELL = 0.0015
"""Side of a cell [m]."""
MAX_OFFSET = 0.36
"""Points farther than this along x or y of the world from what the middle of the image shows are
left out, which bounds the size of the map [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class HeightMap:
    """Heights on a grid whose rows run along y of the world and columns along x."""

    heights: Image
    """(rows, columns) height in the world [m]."""
    origin: Array
    """(2,) x and y of the centre of cell (0, 0) [m]."""
    cell: float = CELL
    """Side of a cell [m]."""
    unknown: Mask | None = None
    """(rows, columns) where something may stand that the image does not show; None is nowhere."""
    rising: Mask | None = None
    """(rows, columns) where that may be as high as the camera: within its minimum range."""

    def at(self, x: Array | Image, y: Array | Image) -> Image:
        """Heights at world positions of any shape [m]; outside the grid, those of its border."""
        return look_up(self.heights, self.origin, self.cell, x, y)

    def cells(self, x: Array | Image, y: Array | Image) -> Indices:
        """Flat indices of the cells at world positions [m]; outside the grid, of its border."""
        return _cells(self.heights.shape, self.origin, self.cell, x, y)


def look_up(values: Image, origin: Array, cell: float, x: Array | Image, y: Array | Image) -> Image:
    """Values of the cells at world positions [m]; outside the grid, those of its border."""
    found: Image = values.ravel().take(_cells(values.shape, origin, cell, x, y))
    return found


def hide_outside(unknown: Mask) -> None:
    """Mark the margin of a map as unknown in place: one cell stands for all that is outside.

    Args:
        unknown: (rows, columns) see `HeightMap`.
    """
    for edge in (unknown, unknown.T):
        edge[[0, -1]] = True


def _cells(
    shape: tuple[int, ...], origin: Array, cell: float, x: Array | Image, y: Array | Image
) -> Indices:
    rows, columns = shape
    # Half a cell is added so that truncation rounds to the nearest.
    column = (x - (origin[0] - 0.5 * cell)) * (1.0 / cell)
    row = (y - (origin[1] - 0.5 * cell)) * (1.0 / cell)
    column = np.clip(column, 0, columns - 1).astype(np.int32)
    row = np.clip(row, 0, rows - 1).astype(np.int32)
    flat: Indices = row * np.int32(columns) + column
    return flat


def build_height_map(
    depth: Image,
    intrinsics: Intrinsics,
    wTc: SE3,
    u: Array,
    v: Array,
    unseen: Occlusion | None = None,
) -> HeightMap:
    """The upper surface of a depth image.

    A cell without a point takes the lower of its two neighbours in the row: behind something higher
    lies the background. A 3x3 median then removes single outliers. Where the image does not show
    what stands there, the cell is unknown besides.

    Args:
        depth: (H, W) without holes [m].
        intrinsics: the camera's pinhole model.
        wTc: camera in the world.
        u: (1, W) columns in the full image [px].
        v: (H, 1) rows in the full image [px].
        unseen: what the image does not show; None if it shows all.
    """
    # Relative to the camera, single precision is exact to a micrometre.
    here = SE3(wTc.rotation, np.array([0.0, 0.0, wTc.translation[2]]))
    x, y, z = (each.ravel() for each in world_maps(depth, intrinsics, here, u, v))
    middle = depth.shape[0] // 2 * depth.shape[1] + depth.shape[1] // 2
    middle_x, middle_y = x[middle], y[middle]
    near = (np.abs(x - middle_x) < MAX_OFFSET) & (np.abs(y - middle_y) < MAX_OFFSET)
    if unseen is not None:
        near &= ~unseen.pixels.ravel()
    if not near.any():
        near[0] = True
    if not near.all():
        x, y, z = x[near], y[near], z[near]
    # Cells lie where those of any other map do. A margin of one stands for all that is outside.
    corner = np.array([x.min(), y.min()], dtype=float) + wTc.translation[:2]
    origin = CELL * (np.rint(corner / CELL) - 1.0)
    first_x, first_y = (origin - wTc.translation[:2]).astype(np.float32)
    column = ((x - first_x) * np.float32(1.0 / CELL) + np.float32(0.5)).astype(np.int32)
    row = ((y - first_y) * np.float32(1.0 / CELL) + np.float32(0.5)).astype(np.int32)
    shape = (int(row.max()) + 2, int(column.max()) + 2)
    heights = np.full(shape, -np.inf, dtype=np.float32)
    np.maximum.at(heights.ravel(), row * np.int32(shape[1]) + column, z)
    empty = np.isinf(heights)
    heights = -fill(-heights, empty)
    unknown = rising = None
    if unseen is not None:
        row, column = np.nonzero(empty)
        at_x, at_y = first_x + CELL * column, first_y + CELL * row
        left_out = np.maximum(np.abs(at_x - middle_x), np.abs(at_y - middle_y)) > MAX_OFFSET - CELL
        at_x, at_y = at_x + wTc.translation[0], at_y + wTc.translation[1]
        unknown = np.zeros(shape, dtype=np.bool_)
        unknown[row, column] = left_out | unseen.hides(at_x, at_y, intrinsics, wTc)
        hide_outside(unknown)
        if unseen.rising.any():
            rising = _filled(shape, origin, unseen.within_range(intrinsics, wTc))
            unknown |= rising
    return HeightMap(
        heights=np.asarray(cv2.medianBlur(heights, 3), dtype=np.float32),
        origin=origin,
        unknown=unknown,
        rising=rising,
    )


def _filled(shape: tuple[int, int], origin: Array, at: Array) -> Mask:
    """(rows, columns) the cells with one of (N, 2) positions in the world [m], or beside one."""
    column, row = np.rint((at - origin) / CELL).astype(np.int64).T
    inside = (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
    cells = np.zeros(shape, dtype=np.uint8)
    cells[row[inside], column[inside]] = 1
    return np.asarray(cv2.dilate(cells, np.ones((3, 3), dtype=np.uint8))) > 0
