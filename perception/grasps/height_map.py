"""Height map of the scene: its upper surface on a regular grid, as seen along the approach.

From straight above that is a map of the world; else of the frame a of `approach`.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from pinocchio import SE3

from perception.frame import Array, Frame, Image, Indices, Mask
from perception.geometry import world_maps, world_points
from perception.grasps.network_input import Crop, fill, valid_depth
from perception.grasps.stereo import Occlusion, rising_holes, unknown_pixels
from robots import Intrinsics

CELL = 0.0015  # side of a cell [m]
MAX_OFFSET = 0.36
"""Largest distance of points, along x or y of the world, from what the middle of the image shows
[m]."""

REACH = 0.07  # of the image beside a crop: the fingers reach no farther from a grasp [m]
_INSIDE = 2  # of the border [px]
_BEHIND = 0.05  # as far behind the ground of a tilted view the camera must see [m]
_EDGE_ON = 1e-6  # cosine of a surface that is seen edge-on: everything is far above or below it


@dataclass(frozen=True, kw_only=True, eq=False)
class HeightMap:
    """Heights on a grid whose rows run along y and columns along x, of the world or of a."""

    heights: Image  # (rows, columns) [m]
    origin: Array  # (2,) x and y of the centre of cell (0, 0) [m]
    cell: float = CELL  # side of a cell [m]
    unknown: Mask | None = None  # (rows, columns) where something hidden may stand; None is nowhere
    rising: Mask | None = None  # (rows, columns) where that may be as high as the camera
    wRa: Array | None = None  # (3, 3) rotation of a in the world; None is a map of the world

    def at(self, x: Array | Image, y: Array | Image) -> Image:
        """Heights at positions of any shape [m]; outside the grid, those of its border."""
        return look_up(self.heights, self.origin, self.cell, x, y)

    def cells(self, x: Array | Image, y: Array | Image) -> Indices:
        """Flat indices of the cells at positions [m]; outside the grid, of its border."""
        return _cells(self.heights.shape, self.origin, self.cell, x, y)

    def above(self, level: float) -> Mask:
        """(rows, columns) which heights are above a level of the world [m]."""
        if self.wRa is None:
            return np.asarray(self.heights > level)
        return np.asarray(self.heights > self.plane(level, *self.positions()))

    def over(self, level: float, x: Array, y: Array, z: Array) -> Array:
        """(N,) how high points are over a level of the world, there [m]."""
        if self.wRa is None:
            return z - level
        height: Array = np.stack([x, y, z], axis=1) @ self.wRa[2] - level
        return height

    def positions(self) -> tuple[Array, Array]:
        """The x (1, columns) and y (rows, 1) of the cells [m]."""
        rows, columns = self.heights.shape
        x, y = (self.origin[i] + self.cell * np.arange(n) for i, n in ((0, columns), (1, rows)))
        return x[None, :], y[:, None]

    def plane(self, level: float, x: Array, y: Array) -> Array | float:
        """Heights at positions of what lies at a level of the world [m]; a slope seen from a.

        Seen edge-on, it is infinitely far below what is above it.
        """
        if self.wRa is None:
            return level
        up = self.wRa[2]
        below: Array = (level - up[0] * x - up[1] * y) / max(float(up[2]), _EDGE_ON)
        return below


def look_up(values: Image, origin: Array, cell: float, x: Array | Image, y: Array | Image) -> Image:
    """Values of the cells at positions [m]; outside the grid, those of its border."""
    found: Image = values.ravel().take(_cells(values.shape, origin, cell, x, y))
    return found


def hide_outside(unknown: Mask) -> None:
    """Mark the margin of a map as unknown in place: it stands for all that is outside."""
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
    wRa: Array | None = None,
) -> HeightMap:
    """The upper surface of a depth image.

    A cell without a point takes the lower of its two neighbours in the row: behind something higher
    lies the background. In a the background may be far away, and what shows it far aside: there a
    cell also counts as low if the camera sees past it. A 3x3 median then removes single outliers.

    Args:
        depth: (H, W) without holes [m].
        intrinsics: the camera's pinhole model.
        wTc: camera in the world, or in a.
        u: (1, W) columns in the full image [px].
        v: (H, 1) rows in the full image [px].
        unseen: what the image does not show; None if it shows all.
        wRa: (3, 3) rotation of a in the world; None is a map of the world.
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
        # Others become a near point, infinitely low: leaving them out would copy all.
        some, others = near.argmax(), ~near
        for each, value in ((x, x[some]), (y, y[some]), (z, -np.inf)):
            np.copyto(each, value, where=others)
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
    unknown = rising = None
    if unseen is not None:
        row, column = np.nonzero(empty)
        at_x, at_y = first_x + CELL * column, first_y + CELL * row
        left_out = np.maximum(np.abs(at_x - middle_x), np.abs(at_y - middle_y)) > MAX_OFFSET - CELL
        at_x, at_y = at_x + wTc.translation[0], at_y + wTc.translation[1]
        unknown = np.zeros(shape, dtype=np.bool_)
        unknown[row, column] = left_out | unseen.hides(at_x, at_y, intrinsics, wTc)
        if wRa is not None:
            level = unseen.ground - _BEHIND
            free = unseen.sees_past(at_x, at_y, level, z.reshape(depth.shape), intrinsics, wTc)
            heights[row[free], column[free]] = level
            empty[row[free], column[free]] = False
    heights = -fill(-heights, empty)
    if unseen is not None and unknown is not None:
        hide_outside(unknown)
        if unseen.rising.any():
            rising = _filled(shape, origin, unseen.within_range(intrinsics, wTc))
            unknown |= rising
    return HeightMap(
        heights=np.asarray(cv2.medianBlur(heights, 3), dtype=np.float32),
        origin=origin,
        unknown=unknown,
        rising=rising,
        wRa=wRa,
    )


def with_floor(scene: HeightMap, floor: float) -> HeightMap:
    """A tilted map in which the support surface is solid, also where nothing shows it.

    `floor` is its height in the world [m]. From straight above everything lies on it anyway.
    """
    if scene.wRa is None:
        return scene
    lowest = scene.plane(floor, *scene.positions())
    return replace(scene, heights=np.maximum(scene.heights, lowest).astype(np.float32))


def _filled(shape: tuple[int, int], origin: Array, at: Array) -> Mask:
    """(rows, columns) the cells at or beside one of (N, 2) positions in the world [m]."""
    column, row = np.rint((at - origin) / CELL).astype(np.int64).T
    inside = (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
    cells = np.zeros(shape, dtype=np.uint8)
    cells[row[inside], column[inside]] = 1
    return np.asarray(cv2.dilate(cells, np.ones((3, 3), dtype=np.uint8))) > 0


@dataclass(frozen=True, kw_only=True, eq=False)
class LocalHeights:
    """What a frame shows in and around a crop."""

    scene: HeightMap
    border: Array
    """(B, 3) points along the border of what the image shows, and round its holes, in the world
    [m]."""


def local_heights(
    frame: Frame, depth: Image, crop: Crop, support: float, wRa: Array | None = None
) -> LocalHeights:
    """The heights of a crop and, as far as the image shows it, of `REACH` around it.

    `support` is the depth of the support surface along the optical axis [m]; the frame is in a if
    there is a `wRa`, the (3, 3) rotation of a in the world.

    Raises:
        NoDepthError: no pixel has a depth.
    """
    more = int(REACH * frame.intrinsics.fx / support)
    u, v = (
        np.arange(max(first - more, 0), min(first + crop.size + more, end))
        for first, end in ((crop.u0, depth.shape[1]), (crop.v0, depth.shape[0]))
    )
    part = depth[v[0] : v[-1] + 1, u[0] : u[-1] + 1]
    missing = ~valid_depth(part)
    filled = fill(part, missing)
    unknown = unknown_pixels(part, missing, frame.intrinsics.fx, support)
    unseen = Occlusion(
        pixels=unknown,
        rising=rising_holes(part, missing, unknown),
        corner=(int(u[0]), int(v[0])),
        ground=float(frame.wTc.act(np.array([0.0, 0.0, support]))[2]),
    )
    u, v = u.astype(float)[None, :], v.astype(float)[:, None]
    return LocalHeights(
        scene=build_height_map(filled, frame.intrinsics, frame.wTc, u, v, unseen, wRa),
        border=_border(frame, filled, unseen.pixels, u, v),
    )


def _border(frame: Frame, depth: Image, unseen: Mask, u: Array, v: Array) -> Array:
    rows, columns = (np.arange(_INSIDE, n - _INSIDE) for n in depth.shape)
    row = np.concatenate([rows, rows, np.repeat(rows[[0, -1]], len(columns))])
    column = np.concatenate([np.repeat(columns[[0, -1]], len(rows)), columns, columns])
    wider = cv2.dilate(unseen.astype(np.uint8), np.ones((2 * _INSIDE + 1,) * 2, dtype=np.uint8))
    beside_row, beside_column = np.divmod(np.flatnonzero(wider > unseen), depth.shape[1])
    row, column = np.append(row, beside_row), np.append(column, beside_column)
    return world_points(depth[row, column], frame.intrinsics, frame.wTc, u[0, column], v[row, 0])
