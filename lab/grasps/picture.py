"""Pictures of depth images and the grasps found in them."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import TypeAlias

import cv2
import numpy as np
import numpy.typing as npt

from perception import Detection, GraspEstimate
from robots import Intrinsics

Picture: TypeAlias = npt.NDArray[np.uint8]
"""(H, W, 3) blue, green, red, as in OpenCV."""

_BEST, _OTHER, _TEXT = (60, 60, 240), (200, 180, 60), (255, 255, 255)
_SHOWN = 5  # number of grasps
_LINE, _LETTER = 18, 9  # height of a line and width of a letter of the caption [px]
_PAD_HALF = 0.010  # half of the drawn length of a finger pad [m]


def depth_picture(depth: npt.NDArray[np.float32]) -> Picture:
    """A depth image from near (bright) to far (dark); missing depth is blue."""
    known = np.isfinite(depth) & (depth > 0.0)
    low, high = np.percentile(depth[known], (1, 99)) if known.any() else (0.0, 1.0)
    scaled = np.clip((high - np.where(known, depth, high)) / max(high - low, 1e-3), 0.0, 1.0)
    grey = (40.0 + 200.0 * scaled).astype(np.uint8)
    picture = np.repeat(grey[..., None], 3, axis=2)
    picture[~known] = (90, 40, 20)
    return picture


def overlay(
    depth: npt.NDArray[np.float32], intrinsics: Intrinsics, detection: Detection, caption: str = ""
) -> Picture:
    """A depth image with the quality and the best grasps drawn over it, and a caption below.

    Args:
        depth: (H, W) [m].
        intrinsics: of the camera.
        detection: the grasps found in it.
        caption: text below; if empty, the reason why there is no grasp.
    """
    picture = depth_picture(depth)
    u, v, size = (round(x) for x in detection.crop)
    if size > 0:
        quality = cv2.resize(detection.quality, (size, size), interpolation=cv2.INTER_LINEAR)
        quality = np.clip(quality, 0.0, 1.0)
        colours = cv2.applyColorMap((255 * quality).astype(np.uint8), cv2.COLORMAP_INFERNO)
        part = picture[v : v + size, u : u + size]
        weight = (0.6 * np.sqrt(quality))[: part.shape[0], : part.shape[1], None]
        part[:] = ((1 - weight) * part + weight * colours[: part.shape[0], : part.shape[1]]).astype(
            np.uint8
        )
    for rank, grasp in reversed(list(enumerate(detection.grasps[:_SHOWN]))):
        _draw(picture, grasp, depth, intrinsics, _OTHER if rank else _BEST)
    lines = wrap(caption or detection.reason, picture.shape[1] // _LETTER)
    below = np.zeros((_LINE * len(lines) + 8, picture.shape[1], 3), dtype=np.uint8)
    for number, line in enumerate(lines, 1):
        font = cv2.FONT_HERSHEY_SIMPLEX
        cv2.putText(below, line, (6, _LINE * number), font, 0.45, _TEXT, 1, cv2.LINE_AA)
    return np.vstack([picture, below])


def _draw(
    picture: Picture,
    grasp: GraspEstimate,
    depth: npt.NDArray[np.float32],
    intrinsics: Intrinsics,
    colour: tuple[int, int, int],
) -> None:
    """A rectangle as wide as the opening; its thick sides are the finger pads."""
    u, v = grasp.pixel
    row, column = np.clip(np.rint((v, u)).astype(int), 0, np.array(depth.shape) - 1)
    distance = depth[row, column]
    if not np.isfinite(distance) or distance <= 0.0:
        distance = float(np.nanmedian(depth))
    along = 0.5 * grasp.opening * intrinsics.fx / distance
    across = _PAD_HALF * intrinsics.fx / distance
    direction = np.array([np.cos(grasp.angle), np.sin(grasp.angle)])
    normal = np.array([-direction[1], direction[0]])
    centre = np.array([u, v])
    corners = [
        tuple(np.rint(centre + a * along * direction + b * across * normal).astype(int).tolist())
        for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    for index, thick in enumerate((1, 3, 1, 3)):
        cv2.line(
            picture, corners[index], corners[(index + 1) % 4], colour, thick, lineType=cv2.LINE_AA
        )


def side_by_side(pictures: Sequence[Picture], columns: int = 4) -> Picture:
    """Pictures of equal width in rows, padded at the bottom to equal height."""
    height = max(len(picture) for picture in pictures)
    full = [np.pad(p, ((0, height - len(p)), (0, 0), (0, 0))) for p in pictures]
    padded = [*full, *[np.zeros_like(full[0])] * (-len(full) % columns)]
    rows = [np.hstack(padded[i : i + columns]) for i in range(0, len(padded), columns)]
    return np.vstack(rows)
