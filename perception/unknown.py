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
from perception.geometry import Camera
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
    edges = np.diff(np.pad(missing.astype(np.int8), ((0, 0), (1, 1))), axis=1)
    row, begin = np.nonzero(edges == 1)
    _, end = np.nonzero(edges == -1)
    width = depth.shape[1]
    left = np.where(begin > 0, depth[row, np.maximum(begin - 1, 0)], farthest)
    right = np.where(end < width, depth[row, np.minimum(end, width - 1)], farthest)
    shadow = fx * BASELINE * np.abs(1.0 / left - 1.0 / right)
    wide = end - begin > shadow + _MARGIN
    # Runs of ones between +1 at their beginning and -1 past their end.
    steps = np.zeros((depth.shape[0], width + 1), dtype=np.int8)
    steps[row[wide], begin[wide]] = 1
    steps[row[wide], end[wide]] = -1
    unknown = np.cumsum(steps, axis=1, dtype=np.int8)[:, :width].astype(np.uint8)
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
        ground = np.column_stack([x, y, np.full(len(x), self.ground)])
        u, v = np.rint(Camera(intrinsics=intrinsics, wTc=wTc).project(ground)).astype(np.int64).T
        column, row = u - self.corner[0], v - self.corner[1]
        rows, columns = self.pixels.shape
        inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
        hidden: Mask = ~inside
        hidden[inside] = self.pixels[row[inside], column[inside]]
        return hidden
