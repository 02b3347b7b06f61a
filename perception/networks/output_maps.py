"""Candidate grasps as local maxima of GG-CNN's maps, in cells of 3x3 input pixels.

The cosine and sine maps are smoothed, not the angle, which wraps at half a turn.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from config.arrays import Array, Image, Indices, Mask
from perception.grasps.candidates import Candidates
from perception.grasps.network_input import INPUT_SIZE, OUTPUT_STRIDE, WIDTH_SCALE

SMOOTHING = 0.7  # standard deviation of the blur of quality, cosine and sine [cells]
REACH = 3  # of the blur, four standard deviations [cells]

_COUNT = 16  # candidates at most
_APART = 2  # no better cell is within this of a maximum, along u or v [cells]
_LEAST = 0.05  # smallest quality; also a tenth of the best is required


@dataclass(frozen=True, kw_only=True, eq=False)
class GraspMaps:
    """GG-CNN's output in every cell, smoothed."""

    quality: Image  # (100, 100) 0 where no grasp is allowed
    angle: Image  # (100, 100) closing direction, from u towards v, in (-π/2, π/2] [rad]
    width: Image  # (100, 100) opening [input px]

    def quality_in_input(self) -> Image:
        """(INPUT_SIZE, INPUT_SIZE) the quality at every input pixel."""
        size = (INPUT_SIZE, INPUT_SIZE)
        enlarged = cv2.resize(self.quality, size, interpolation=cv2.INTER_LINEAR)
        return np.asarray(enlarged, dtype=np.float32)


def grasp_maps(maps: Image, allowed: Mask) -> GraspMaps:
    """Smooth the raw maps of GG-CNN (4, 100, 100): quality, cosine, sine, width / 150 px."""
    size = (2 * REACH + 1, 2 * REACH + 1)
    quality, cosine, sine = (
        np.asarray(cv2.GaussianBlur(layer, size, SMOOTHING), dtype=np.float32) for layer in maps[:3]
    )
    return GraspMaps(
        quality=np.where(allowed, np.clip(quality, 0.0, 1.0), 0.0).astype(np.float32),
        angle=np.float32(-0.5) * np.arctan2(sine, cosine),  # the network measures it against v
        width=np.float32(WIDTH_SCALE) * np.maximum(maps[3], np.float32(0.0)),
    )


def find_candidates(maps: GraspMaps) -> Candidates:
    """Local maxima of the quality."""
    quality = maps.quality
    neighbourhood = np.ones((2 * _APART + 1, 2 * _APART + 1), dtype=np.uint8)
    peak = quality >= cv2.dilate(quality, neighbourhood)
    peak &= quality > max(_LEAST, 0.1 * float(quality.max()))
    v, u = (found.astype(np.int64) for found in np.nonzero(peak))
    order = np.argsort(-quality[v, u], kind="stable")[:_COUNT]
    v, u = v[order], u[order]
    cell = np.stack([u + _subpixel(quality, v, u, 0, 1), v + _subpixel(quality, v, u, 1, 0)], 1)
    return Candidates(
        pixel=OUTPUT_STRIDE * cell + (OUTPUT_STRIDE - 1) / 2.0,
        angle=maps.angle[v, u].astype(float),
        width=maps.width[v, u].astype(float),
        quality=quality[v, u].astype(float),
    )


def _subpixel(values: Image, v: Indices, u: Indices, dv: int, du: int) -> Array:
    """Offset of each peak along v or u, by the parabola through three neighbours [cells]."""
    rows, columns = values.shape

    def at(step: int) -> Array:
        row = np.clip(v + step * dv, 0, rows - 1)
        column = np.clip(u + step * du, 0, columns - 1)
        return values[row, column].astype(float)

    before, here, after = at(-1), at(0), at(1)
    curvature = before - 2.0 * here + after
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = np.where(curvature < 0.0, 0.5 * (before - after) / curvature, 0.0)
    return np.asarray(np.clip(offset, -0.5, 0.5))
