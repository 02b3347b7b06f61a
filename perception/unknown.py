"""What a depth image does not show, and where on the ground that may stand.

A hole in a stereo image has a cause. In the *shadow* of a nearer surface, which only one of the two
imagers sees, lies the background; no shadow is wider than the difference of the disparities. Every
other wide hole may be anything: a thing within the minimum range, one that gives no return. Nor
does the image tell what is beyond its border.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from pinocchio import SE3

from perception.arrays import Array, Image, Mask
from robots import Intrinsics

BASELINE = 0.05
"""Between the imagers of the camera; that of a RealSense D435 [m]."""
TALLEST = 0.08
"""What is unknown may be as high above the ground as this, under the palm [m]."""
_MARGIN = 8  # a shadow with the lost pixels of its edges is at most so much wider [px]
_SMALLEST = 5  # narrower holes are speckles, along rows and columns [px]


def unknown_pixels(depth: Image, missing: Mask, fx: float, farthest: float) -> Mask:
    """Which of the missing pixels are not in the shadow of a nearer surface.

    Args:
        depth: (H, W) [m].
        missing: (H, W) which pixels have no depth.
        fx: focal length along the rows [px].
        farthest: depth of the background where a hole reaches the border of the image [m].
    """
    width = depth.shape[1]
    pixel = np.flatnonzero(missing)
    unknown = np.zeros(depth.shape, dtype=np.uint8)
    if len(pixel) == 0:
        return unknown.astype(np.bool_)
    column = pixel % width
    starts = np.concatenate([[True], (np.diff(pixel) > 1) | (column[1:] == 0)])
    first = np.flatnonzero(starts)  # of each hole in its row
    last = np.append(first[1:], len(pixel)) - 1
    values = depth.ravel()
    left = np.where(column[first] > 0, values[pixel[first] - 1], farthest)
    after = np.minimum(pixel[last] + 1, depth.size - 1)
    right = np.where(column[last] + 1 < width, values[after], farthest)
    shadow = fx * BASELINE * np.abs(1.0 / left - 1.0 / right)
    wide = last + 1 - first > shadow + _MARGIN
    unknown.ravel()[pixel[wide[np.cumsum(starts) - 1]]] = 1
    square = np.ones((_SMALLEST, _SMALLEST), dtype=np.uint8)
    opened: Mask = np.asarray(cv2.morphologyEx(unknown, cv2.MORPH_OPEN, square)) > 0
    return opened


@dataclass(frozen=True, kw_only=True, eq=False)
class Unseen:
    """What a crop of a depth image does not show, above the ground."""

    pixels: Mask
    """(H, W) which pixels of the crop show nothing, and are no shadow; see `unknown_pixels`."""
    corner: tuple[int, int]
    """(u, v) of the crop's first pixel in the full image [px]."""
    ground: float
    """Height of the ground in the world [m]."""

    def hides(self, x: Array, y: Array, intrinsics: Intrinsics, wTc: SE3) -> Mask:
        """At which (N,) positions in the world [m] something unknown may stand.

        Whatever stands on the ground hides the ground below itself. So the ground is projected into
        the image: outside, or in a hole, something unknown may stand there. Where a measured thing
        hides the ground, nothing else is supposed to.
        """
        camera = wTc.inverse()
        ground = camera.rotation[:, 2] * self.ground + camera.translation
        along_x, along_y, along_z = (
            camera.rotation[axis, 0] * x + camera.rotation[axis, 1] * y + ground[axis]
            for axis in range(3)
        )
        u = intrinsics.fx * along_x / along_z + (intrinsics.cx - self.corner[0])
        v = intrinsics.fy * along_y / along_z + (intrinsics.cy - self.corner[1])
        column, row = np.rint(u).astype(np.int32), np.rint(v).astype(np.int32)
        rows, columns = self.pixels.shape
        inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
        hidden: Mask = ~inside
        hidden[inside] = self.pixels[row[inside], column[inside]]
        return hidden
