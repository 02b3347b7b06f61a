"""The heights in and around a crop: of all that a hand may touch that grasps there."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from perception.frame import Array, Frame, Image, Mask
from perception.geometry import world_points
from perception.grasps.height_map import HeightMap, build_height_map
from perception.grasps.network_input import Crop, fill, valid_depth
from perception.grasps.stereo import Occlusion, rising_holes, unknown_pixels

REACH = 0.07
"""Beside the crop, so much of the image is looked at: the fingers reach no farther from a grasp at
its border. The palm does, and what it finds beyond is unknown [m]."""
_INSIDE = 2  # of the border by so many pixels


@dataclass(frozen=True, kw_only=True, eq=False)
class LocalHeights:
    """What a frame shows in and around a crop."""

    scene: HeightMap
    """Measured heights."""
    border: Array
    """(B, 3) points along the border of what the image shows, and round what it does not show
    within, as beside the hand, in the world [m]."""


def local_heights(frame: Frame, depth: Image, crop: Crop, support: float) -> LocalHeights:
    """The heights of a crop and, as far as the image shows it, of `REACH` around it.

    Args:
        frame: with the camera's model and pose.
        depth: (H, W) of the frame [m].
        crop: where grasps are looked for.
        support: depth of the support surface along the optical axis [m].

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
        scene=build_height_map(filled, frame.intrinsics, frame.wTc, u, v, unseen),
        border=_border(frame, filled, unseen.pixels, u, v),
    )


def _border(frame: Frame, depth: Image, unseen: Mask, u: Array, v: Array) -> Array:
    rows, columns = (np.arange(_INSIDE, n - _INSIDE) for n in depth.shape)
    row = np.concatenate([rows, rows, np.repeat(rows[[0, -1]], len(columns))])
    column = np.concatenate([np.repeat(columns[[0, -1]], len(rows)), columns, columns])
    wider = cv2.dilate(unseen.astype(np.uint8), np.ones((2 * _INSIDE + 1,) * 2, dtype=np.uint8))
    beside_row, beside_column = np.nonzero((wider > 0) & ~unseen)
    row, column = np.append(row, beside_row), np.append(column, beside_column)
    return world_points(depth[row, column], frame.intrinsics, frame.wTc, u[0, column], v[row, 0])
