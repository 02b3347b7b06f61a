"""Stereo depth: smoothing of noise, and what a depth image does not show.

Far depth is noisy: a stereo camera measures disparity, and at 1.5 m a tenth of a pixel is 12 mm. A
hole in a stereo image is the *shadow* of a nearer surface, seen by one imager only and no wider
than the difference of the disparities; every other wide hole may hide anything, and so does what is
beyond the border.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from pinocchio import SE3

from perception.frame import Array, Image, Indices, Mask
from perception.geometry import world_maps, world_points
from perception.grasps.network_input import holes, valid_depth
from robots import Intrinsics

BASELINE = 0.05  # between the imagers of a RealSense D435 [m]
NEAREST = 0.175  # minimum range of a RealSense D435 [m]
TALLEST = 0.08  # assumed height of hidden objects above the ground, under the palm [m]
_MARGIN = 8  # by which a shadow is wider, with the lost pixels of its edges [px]
_SMALLEST = 5  # narrower holes are speckles, along rows and columns [px]
_RISING = 0.02  # a surface farther than `NEAREST` by less than this may come nearer [m]
_BESIDE = 7  # a surface that ends this near to a hole goes on in it [px]
_TOUCHING = 10  # pixels of a hole beside such a surface
_NEARER = np.linspace(0.06, NEAREST, 11)  # depths at which nearer objects are assumed [m]

FAR = 0.8  # from here on the noise is worse than what averaging takes from small objects [m]
_WINDOW = 7  # side of the neighbourhood [px]
_NEAR = 3.0  # standard deviation of the weight with the distance in the image [px]
_SIMILAR = 0.4  # and with the difference of disparities [px]
_NOTHING = -1e3  # so unlike any disparity that it has no weight [px]


def smoothed(depth: Image, fx: float) -> Image:
    """(H, W) depth [m] with less noise; missing pixels stay missing.

    Disparities are averaged over neighbours on the same surface (bilateral filter, Tomasi and
    Manduchi, 1998); `fx` is the focal length along the rows [px].
    """
    valid = valid_depth(depth)
    scale = np.float32(fx * BASELINE)
    disparity = np.full(depth.shape, _NOTHING, dtype=np.float32)
    disparity[valid] = scale / depth[valid]
    averaged = np.asarray(cv2.bilateralFilter(disparity, _WINDOW, _SIMILAR, _NEAR))
    result = np.full(depth.shape, np.nan, dtype=np.float32)
    result[valid] = scale / averaged[valid]
    return result


def unknown_pixels(depth: Image, missing: Mask, fx: float, farthest: float) -> Mask:
    """(H, W) which of the missing pixels are not in the shadow of a nearer surface.

    `fx` is the focal length along the rows [px], `farthest` the depth of the background beyond the
    border of the image [m].
    """
    width, values = depth.shape[1], depth.ravel()
    first, last = holes(missing)
    left = np.where(first % width > 0, values[first - 1], farthest)
    right = np.where((last + 1) % width > 0, values[(last + 1) % depth.size], farthest)
    shadow = fx * BASELINE * np.abs(1.0 / left - 1.0 / right)
    wide = last + 1 - first > shadow + _MARGIN
    unknown = np.zeros(depth.shape, dtype=np.uint8)
    unknown[missing] = np.repeat(wide, last + 1 - first)
    square = np.ones((_SMALLEST, _SMALLEST), dtype=np.uint8)
    opened: Mask = np.asarray(cv2.morphologyEx(unknown, cv2.MORPH_OPEN, square)) > 0
    return opened


def near_floor_filled(depth: Image, intrinsics: Intrinsics, wTc: SE3, floor: float) -> Image:
    """(H, W) depth [m] with the support surface where it is within the minimum range of the camera.

    A camera beside an object looks over that: its hole hides nothing. `floor` is the height of the
    surface in the world [m].
    """
    row, column = np.nonzero(~valid_depth(depth))
    u, v = column.astype(float), row.astype(float)
    direction = SE3(wTc.rotation, np.zeros(3))
    (rise,) = world_maps(np.ones(len(row)), intrinsics, direction, u, v, axes=(2,))
    there = (floor - wTc.translation[2]) / np.minimum(rise, -1e-6)
    shown = (there > 0.0) & (there < NEAREST + _RISING)
    filled = np.array(depth)
    filled[row[shown], column[shown]] = there[shown]
    return filled


def rising_holes(depth: Image, missing: Mask, unknown: Mask) -> Mask:
    """Which of the unknown pixels may show an object within the minimum range of the camera.

    They are those of a hole beside which something is about as near as `NEAREST`: a tall object
    whose upper part the camera does not measure.
    """
    rising = ~missing & (depth < NEAREST + _RISING)
    if not rising.any() or not unknown.any():
        return np.zeros(depth.shape, dtype=np.bool_)
    count, holes = cv2.connectedComponents(unknown.astype(np.uint8))
    beside = cv2.dilate(rising.astype(np.uint8), np.ones((_BESIDE, _BESIDE), dtype=np.uint8)) > 0
    is_rising = np.bincount(holes[beside], minlength=count) >= _TOUCHING
    is_rising[0] = False
    return np.asarray(is_rising[holes])


@dataclass(frozen=True, kw_only=True, eq=False)
class Occlusion:
    """What a crop of a depth image does not show, above the ground."""

    pixels: Mask  # (H, W) see `unknown_pixels`
    corner: tuple[int, int]  # (u, v) of the crop's first pixel in the full image [px]
    ground: float  # height of the ground in the world [m]
    rising: Mask  # (H, W) see `rising_holes`

    def within_range(self, intrinsics: Intrinsics, wTc: SE3) -> Array:
        """(N, 2) x and y in the world [m] where an object nearer than `NEAREST` may be."""
        row, column = (each[:, None] for each in np.nonzero(self.rising))
        points = world_points(
            np.broadcast_to(_NEARER, (len(row), len(_NEARER))),
            intrinsics,
            wTc,
            (column + self.corner[0]).astype(float),
            (row + self.corner[1]).astype(float),
        )
        return points[..., :2].reshape(-1, 2)

    def hides(self, x: Array, y: Array, intrinsics: Intrinsics, wTc: SE3) -> Mask:
        """(N,) at which positions in the world [m] something hidden may stand.

        An object on the ground hides the ground below itself. So the ground is projected into the
        image: outside, or in a hole, an object may stand there. Where a measured object hides the
        ground, only that object itself may be taller, where the image ends below `TALLEST`.
        """
        cTw = wTc.inverse()
        inside = self._inside(*self._pixel(x, y, self.ground + TALLEST, intrinsics, cTw))
        column, row = self._pixel(x, y, self.ground, intrinsics, cTw)
        inside &= self._inside(column, row)
        hidden: Mask = ~inside
        hidden[inside] = self.pixels[row[inside], column[inside]]
        return hidden

    def sees_past(
        self, x: Array, y: Array, height: float, seen: Image, intrinsics: Intrinsics, wTc: SE3
    ) -> Mask:
        """(N,) at which positions at a height the image shows what is lower.

        `seen` (H, W) are the heights that the pixels show [m].
        """
        column, row = self._pixel(x, y, height, intrinsics, wTc.inverse())
        past = self._inside(column, row)
        row, column = row[past], column[past]
        past[past] = ~self.pixels[row, column] & (seen[row, column] < height)
        return past

    def _pixel(
        self, x: Array, y: Array, height: float, intrinsics: Intrinsics, cTw: SE3
    ) -> tuple[Indices, Indices]:
        """Columns and rows of the crop (N,) at which positions at a height are seen."""
        level = cTw.rotation[:, 2] * height + cTw.translation
        along_x, along_y, along_z = (
            cTw.rotation[axis, 0] * x + cTw.rotation[axis, 1] * y + level[axis] for axis in range(3)
        )
        u = intrinsics.fx * along_x / along_z + (intrinsics.cx - self.corner[0])
        v = intrinsics.fy * along_y / along_z + (intrinsics.cy - self.corner[1])
        return np.rint(u).astype(np.int32), np.rint(v).astype(np.int32)

    def _inside(self, column: Indices, row: Indices) -> Mask:
        rows, columns = self.pixels.shape
        inside: Mask = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
        return inside
