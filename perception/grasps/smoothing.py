"""Far depth is noisy: a stereo camera measures disparity, and depth goes with its inverse.

At 1.5 m a tenth of a pixel is 12 mm, as much as many things are high. Where it matters, disparities
are averaged over neighbours of the same surface (bilateral filter, Tomasi and Manduchi, 1998).
"""

from __future__ import annotations

import cv2
import numpy as np

from perception.frame import Image
from perception.grasps.network_input import valid_depth
from perception.grasps.stereo import BASELINE

FAR = 0.8
"""Farther than this the noise is worse than what averaging takes from small things [m]."""
_WINDOW = 7  # side of the neighbourhood [px]
_NEAR = 3.0  # standard deviation of the weight with the distance in the image [px]
_ALIKE = 0.4  # and of that with the difference of disparities [px]
_NOTHING = -1e3  # so unlike any disparity that it has no weight [px]


def smoothed(depth: Image, fx: float) -> Image:
    """The depth [m] with less noise; a missing pixel stays missing.

    Args:
        depth: (H, W) [m].
        fx: focal length along the rows [px].
    """
    valid = valid_depth(depth)
    scale = np.float32(fx * BASELINE)
    disparity = np.full(depth.shape, _NOTHING, dtype=np.float32)
    disparity[valid] = scale / depth[valid]
    averaged = np.asarray(cv2.bilateralFilter(disparity, _WINDOW, _ALIKE, _NEAR))
    result = np.full(depth.shape, np.nan, dtype=np.float32)
    result[valid] = scale / averaged[valid]
    return result
