"""Height map of the scene: its upper surface on a regular grid, as seen along the approach.

From straight above that is a map of the world; else of the frame a of `view`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np
from pinocchio import SE3

from config.arrays import Array, Image, Indices, Mask
from perception.cloud import DepthCloud
from perception.geometry import world_maps
from perception.grasps.network_input import Crop, fill, gaps_in
from perception.grasps.stereo import Occlusion, rising_holes, unknown_pixels

CELL = 0.0015  # side of a cell [m]
MAX_OFFSET = 0.36
"""Largest distance of points, along x or y in odometry, from what the middle of the image shows
[m]."""

REACH = 0.07  # of the image beside a crop: the fingers reach no farther from a grasp [m]
_INSIDE = 2  # of the border [px]
_BEHIND = 0.05  # as far behind the ground of a tilted view the camera must see [m]
_EDGE_ON = 1e-6  # cosine of a surface that is seen edge-on: everything is far above or below it


@dataclass(frozen=True, kw_only=True, eq=False)
class HeightMap:
    """Heights on a grid whose rows run along y and columns along x, in odometry or of a."""

    heights: Image  # (rows, columns) [m]
    origin: Array  # (2,) x and y of the centre of cell (0, 0) [m]
    cell: float = CELL  # side of a cell [m]
    unknown: Mask | None = None  # (rows, columns) where something hidden may stand; None is nowhere
    rising: Mask | None = None  # (rows, columns) where that may be as high as the camera
    oRa: Array | None = None  # (3, 3) rotation of a in odometry; None is a map of the world

    def at(self, x: Array | Image, y: Array | Image) -> Image:
        """Heights at positions of any shape [m]; outside the grid, those of its border."""
        found: Image = self.heights.ravel().take(self.cells(x, y))
        return found

    def cells(self, x: Array | Image, y: Array | Image) -> Indices:
        """Flat indices of the cells at positions [m]; outside the grid, of its border."""
        rows, columns = self.heights.shape
        # Half a cell is added so that truncation rounds to the nearest.
        column = (x - (self.origin[0] - 0.5 * self.cell)) * (1.0 / self.cell)
        row = (y - (self.origin[1] - 0.5 * self.cell)) * (1.0 / self.cell)
        column = np.clip(column, 0, columns - 1).astype(np.int32)
        row = np.clip(row, 0, rows - 1).astype(np.int32)
        flat: Indices = row * np.int32(columns) + column
        return flat

    def every(self, step: int) -> HeightMap:
        """Every n-th row and column, without what may rise."""
        unknown = None if self.unknown is None else self.unknown[::step, ::step]
        heights, cell = self.heights[::step, ::step], step * self.cell
        return replace(self, heights=heights, cell=cell, unknown=unknown, rising=None)

    def above(self, level: float) -> Mask:
        """(rows, columns) which heights are above a level in odometry [m]."""
        if self.oRa is None:
            return np.asarray(self.heights > level)
        return np.asarray(self.heights > self.plane(level, *self.positions()))

    def over(self, level: float, x: Array, y: Array, z: Array) -> Array:
        """(N,) how high points are over a level in odometry, there [m]."""
        if self.oRa is None:
            return z - level
        height: Array = np.stack([x, y, z], axis=1) @ self.oRa[2] - level
        return height

    def in_world(self, points: Array) -> Array:
        """(..., 3) points of the map in odometry [m]."""
        return points if self.oRa is None else points @ self.oRa.T

    def positions(self) -> tuple[Array, Array]:
        """The x (1, columns) and y (rows, 1) of the cells [m]."""
        rows, columns = self.heights.shape
        x, y = (self.origin[i] + self.cell * np.arange(n) for i, n in ((0, columns), (1, rows)))
        return x[None, :], y[:, None]

    def plane(self, level: float, x: Array, y: Array) -> Array | float:
        """Heights at positions of what lies at a level in odometry [m]; a slope seen from a.

        Seen edge-on, it is infinitely far below what is above it.
        """
        if self.oRa is None:
            return level
        up = self.oRa[2]
        below: Array = (level - up[0] * x - up[1] * y) / max(float(up[2]), _EDGE_ON)
        return below


def hide_outside(unknown: Mask) -> None:
    """Mark the margin of a map as unknown in place: it stands for all that is outside."""
    for edge in (unknown, unknown.T):
        edge[[0, -1]] = True


def build_height_map(
    cloud: DepthCloud, unseen: Occlusion | None = None, oRa: Array | None = None
) -> HeightMap:
    """The upper surface of a depth image without holes.

    A cell without a point takes the lower of its two neighbours in the row: behind something higher
    lies the background. In a the background may be far away, and what shows it far aside: there a
    cell also counts as low if the camera sees past it. A 3x3 median then removes single outliers.

    Args:
        cloud: of the image, in odometry or in a.
        unseen: what the image does not show; None if it shows all.
        oRa: (3, 3) rotation of a in odometry; None is a map of the world.
    """
    # Relative to the camera, single precision is exact to a micrometre.
    depth, oTc = cloud.depth, cloud.oTc
    rows, columns = depth.shape
    here = SE3(oTc.rotation, np.array([0.0, 0.0, oTc.translation[2]]))
    u, v = np.arange(columns, dtype=float)[None, :], np.arange(rows, dtype=float)[:, None]
    x, y, z = (each.ravel() for each in world_maps(depth, cloud.intrinsics, here, u, v))
    middle = rows // 2 * columns + columns // 2
    middle_x, middle_y = x[middle], y[middle]
    others = np.zeros(len(x), dtype=np.bool_) if unseen is None else unseen.pixels.flatten()
    for each, at in ((x, middle_x), (y, middle_y)):
        if max(each.max() - at, at - each.min()) >= MAX_OFFSET:
            others |= np.abs(each - at) >= MAX_OFFSET
    some = others.argmin()  # the first that counts, if any
    others[some] = False
    # Others become a near point, infinitely low: leaving them out would copy all.
    left_out = np.flatnonzero(others)
    x[left_out], y[left_out], z[left_out] = x[some], y[some], -np.inf
    # Cells lie where those of any other map do. A margin of one stands for all that is outside.
    corner = np.array([x.min(), y.min()], dtype=float) + oTc.translation[:2]
    origin = CELL * (np.rint(corner / CELL) - 1.0)
    first_x, first_y = (origin - oTc.translation[:2]).astype(np.float32)
    column, row = (_nearest_cell(each, at) for each, at in ((x, first_x), (y, first_y)))
    shape = (int(row.max()) + 2, int(column.max()) + 2)
    heights = np.full(shape, -np.inf, dtype=np.float32)
    row *= np.int32(shape[1])
    row += column
    np.maximum.at(heights.ravel(), row, z)
    empty = np.isinf(heights)
    unknown = rising = None
    if unseen is not None:
        row, column = np.nonzero(empty)
        at_x, at_y = first_x + CELL * column, first_y + CELL * row
        beyond = np.maximum(np.abs(at_x - middle_x), np.abs(at_y - middle_y)) > MAX_OFFSET - CELL
        at_x, at_y = at_x + oTc.translation[0], at_y + oTc.translation[1]
        unknown = np.zeros(shape, dtype=np.bool_)
        unknown[row, column] = beyond | unseen.hides(at_x, at_y)
        if oRa is not None:
            level = unseen.ground - _BEHIND
            free = unseen.sees_past(at_x, at_y, level, z.reshape(depth.shape))
            heights[row[free], column[free]] = level
            empty[row[free], column[free]] = False
    heights = -fill(-heights, empty)
    if unseen is not None and unknown is not None:
        hide_outside(unknown)
        if unseen.rising.any():
            rising = _filled(shape, origin, unseen.within_range())
            unknown |= rising
    return HeightMap(
        heights=np.asarray(cv2.medianBlur(heights, 3), dtype=np.float32),
        origin=origin,
        unknown=unknown,
        rising=rising,
        oRa=oRa,
    )


def _nearest_cell(position: Image, first: float) -> Indices:
    """Numbers (N,) of the cells at positions; the first is at `first` [m]. Overwrites these."""
    position -= first
    position *= np.float32(1.0 / CELL)
    position += np.float32(0.5)
    cell: Indices = position.astype(np.int32)
    return cell


def with_floor(scene: HeightMap, floor: float) -> HeightMap:
    """A tilted map in which the support surface is solid, also where nothing shows it.

    `floor` is its height in odometry [m]. From straight above everything lies on it anyway.
    """
    if scene.oRa is None:
        return scene
    lowest = scene.plane(floor, *scene.positions())
    return replace(scene, heights=np.maximum(scene.heights, lowest).astype(np.float32))


def _filled(shape: tuple[int, int], origin: Array, at: Array) -> Mask:
    """(rows, columns) the cells at or beside one of (N, 2) positions in odometry [m]."""
    column, row = np.rint((at - origin) / CELL).astype(np.int64).T
    inside = (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
    cells = np.zeros(shape, dtype=np.uint8)
    cells[row[inside], column[inside]] = 1
    return np.asarray(cv2.dilate(cells, np.ones((3, 3), dtype=np.uint8))) > 0


class LocalHeights(NamedTuple):
    """What a frame shows in and around a crop."""

    scene: HeightMap
    border: Array
    """(B, 3) points along the border of what the image shows, and round its holes [m]."""


def local_heights(
    cloud: DepthCloud, crop: Crop, support: float, oRa: Array | None = None
) -> LocalHeights:
    """The heights of a crop and, as far as the image shows it, of `REACH` around it.

    `support` is the depth of the support surface along the optical axis [m]; the cloud is in a if
    there is a `oRa`, the (3, 3) rotation of a in odometry.

    Raises:
        NoDepthError: no pixel has a depth.
    """
    more = int(REACH * cloud.intrinsics.fx / support)
    part = cloud.part(*(slice(max(one.start - more, 0), one.stop + more) for one in crop.window))
    missing = ~part.valid
    gaps = gaps_in(missing)
    unknown = unknown_pixels(part.depth, missing, gaps, cloud.intrinsics.fx, support)
    unseen = Occlusion(
        camera=part,
        pixels=unknown,
        rising=rising_holes(part.depth, missing, unknown),
        ground=float(cloud.oTc.act(np.array([0.0, 0.0, support]))[2]),
    )
    filled = part.measuring(fill(part.depth, missing, gaps))
    return LocalHeights(build_height_map(filled, unseen, oRa), _border(filled, unknown))


def _border(filled: DepthCloud, unseen: Mask) -> Array:
    rows, columns = (np.arange(_INSIDE, n - _INSIDE) for n in unseen.shape)
    row = np.concatenate([rows, rows, np.repeat(rows[[0, -1]], len(columns))])
    column = np.concatenate([np.repeat(columns[[0, -1]], len(rows)), columns, columns])
    wider = cv2.dilate(unseen.view(np.uint8), np.ones((2 * _INSIDE + 1,) * 2, dtype=np.uint8))
    beside_row, beside_column = np.divmod(np.flatnonzero(wider > unseen), unseen.shape[1])
    return filled.points(np.append(row, beside_row), np.append(column, beside_column))
