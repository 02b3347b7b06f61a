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

from config.arrays import Array, Image, Indices, Mask
from perception.cloud import DepthCloud
from perception.geometry import Camera, world_maps, world_points
from perception.grasps.network_input import Gaps

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


def smoothed(cloud: DepthCloud) -> DepthCloud:
    """The cloud with less noise; missing pixels stay missing.

    Disparities are averaged over neighbours on the same surface (bilateral filter, Tomasi and
    Manduchi, 1998).
    """
    depth, valid = cloud.depth, cloud.valid
    scale = np.float32(cloud.intrinsics.fx * BASELINE)
    disparity = np.full(depth.shape, _NOTHING, dtype=np.float32)
    disparity[valid] = scale / depth[valid]
    averaged = np.asarray(cv2.bilateralFilter(disparity, _WINDOW, _SIMILAR, _NEAR))
    result = np.full(depth.shape, np.nan, dtype=np.float32)
    result[valid] = scale / averaged[valid]
    return cloud.measuring(result)


def unknown_pixels(depth: Image, missing: Mask, gaps: Gaps, fx: float, farthest: float) -> Mask:
    """(H, W) which of the missing pixels are not in the shadow of a nearer surface.

    `gaps` are those of `missing`; `fx` is the focal length along the rows [px], `farthest` the
    depth of the background beyond the border of the image [m].
    """
    left, right = gaps.beside(depth, farthest)
    shadow = fx * BASELINE * np.abs(1.0 / left - 1.0 / right)
    length = gaps.last + 1 - gaps.first
    unknown = np.zeros(depth.shape, dtype=np.uint8)
    unknown[missing] = np.repeat(length > shadow + _MARGIN, length)
    square = np.ones((_SMALLEST, _SMALLEST), dtype=np.uint8)
    opened: Mask = np.asarray(cv2.morphologyEx(unknown, cv2.MORPH_OPEN, square)) > 0
    return opened


def near_floor_filled(cloud: DepthCloud, floor: float) -> DepthCloud:
    """The cloud with the support surface where it is within the minimum range of the camera.

    A camera beside an object looks over that: its hole hides nothing. `floor` is the height of the
    surface in odometry [m].
    """
    row, column = np.nonzero(~cloud.valid)
    u, v = column.astype(float), row.astype(float)
    direction = SE3(cloud.oTc.rotation, np.zeros(3))
    (rise,) = world_maps(np.ones(len(row)), cloud.intrinsics, direction, u, v, axes=(2,))
    there = (floor - cloud.oTc.translation[2]) / np.minimum(rise, -1e-6)
    shown = (there > 0.0) & (there < NEAREST + _RISING)
    filled = np.array(cloud.depth)
    filled[row[shown], column[shown]] = there[shown]
    return cloud.measuring(filled)


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
    """What a depth image does not show, above the ground."""

    camera: Camera
    pixels: Mask  # (H, W) see `unknown_pixels`
    rising: Mask  # (H, W) see `rising_holes`
    ground: float  # height of the ground in odometry [m]

    def within_range(self) -> Array:
        """(N, 2) x and y in odometry [m] where an object nearer than `NEAREST` may be."""
        v, u = (each[:, None].astype(float) for each in np.nonzero(self.rising))
        depth = np.broadcast_to(_NEARER, (len(v), len(_NEARER)))
        points = world_points(depth, self.camera.intrinsics, self.camera.oTc, u, v)
        return points[..., :2].reshape(-1, 2)

    def hides(self, x: Array, y: Array) -> Mask:
        """(N,) at which positions in odometry [m] something hidden may stand.

        An object on the ground hides the ground below itself. So the ground is projected into the
        image: outside, or in a hole, an object may stand there. Where a measured object hides the
        ground, only that object itself may be taller, where the image ends below `TALLEST`.
        """
        hidden = np.ones(len(x), dtype=np.bool_)
        column, row = self._pixel(x, y, self.ground + TALLEST)
        inside = np.flatnonzero(self._inside(column, row))
        column, row = self._pixel(x[inside], y[inside], self.ground)
        seen = self._inside(column, row)
        hidden[inside[seen]] = self.pixels[row[seen], column[seen]]
        return hidden

    def sees_past(self, x: Array, y: Array, height: float, seen: Image) -> Mask:
        """(N,) at which positions at a height the image shows what is lower.

        `seen` (H, W) are the heights that the pixels show [m].
        """
        column, row = self._pixel(x, y, height)
        past = self._inside(column, row)
        row, column = row[past], column[past]
        past[past] = ~self.pixels[row, column] & (seen[row, column] < height)
        return past

    def _pixel(self, x: Array, y: Array, height: float) -> tuple[Indices, Indices]:
        """Columns and rows (N,) at which positions at a height are seen."""
        cTo, camera = self.camera.oTc.inverse(), self.camera.intrinsics
        level = cTo.rotation[:, 2] * height + cTo.translation
        along_x, along_y, along_z = (
            cTo.rotation[axis, 0] * x + cTo.rotation[axis, 1] * y + level[axis] for axis in range(3)
        )
        u = camera.fx * along_x / along_z + camera.cx
        v = camera.fy * along_y / along_z + camera.cy
        return np.rint(u).astype(np.int32), np.rint(v).astype(np.int32)

    def _inside(self, column: Indices, row: Indices) -> Mask:
        rows, columns = self.pixels.shape
        inside: Mask = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
        return inside
