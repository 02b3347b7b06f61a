"""From the network's maps to a few candidate grasps in the image.

The angle is never smoothed itself, because it jumps by half a turn; its cosine and sine are.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from perception.arrays import Array, Image, Indices, Mask
from perception.maps import WIDTH_SCALE

SMOOTHING = 2.0
"""Standard deviation of the blur of quality, cosine and sine [px]."""
WIDTH_SMOOTHING = 1.0
"""Standard deviation of the blur of the width [px]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class GraspMaps:
    """The network's answer for every pixel, smoothed."""

    quality: Image
    """(300, 300) 0 where no grasp is allowed."""
    angle: Image
    """(300, 300) closing direction, from u towards v, in (-π/2, π/2] [rad]."""
    width: Image
    """(300, 300) opening [network px]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidates:
    """Peaks of the quality, best first."""

    pixel: Array
    """(N, 2) network (u, v), to a fraction of a pixel."""
    angle: Array
    """(N,) closing direction, from u towards v [rad]."""
    width: Array
    """(N,) opening [network px]."""
    quality: Array
    """(N,)."""


def grasp_maps(maps: Image, allowed: Mask) -> GraspMaps:
    """Smooth the raw maps of the network.

    Args:
        maps: (4, 300, 300) quality, cosine, sine, width / 150 px.
        allowed: (300, 300) where a grasp may be: its depth was measured, and it is wanted there.
    """
    quality, cosine, sine = (_blur(layer, SMOOTHING) for layer in maps[:3])
    return GraspMaps(
        quality=np.where(allowed, np.clip(quality, 0.0, 1.0), 0.0).astype(np.float32),
        angle=np.float32(-0.5) * np.arctan2(sine, cosine),  # the network counts against v
        width=np.float32(WIDTH_SCALE)
        * np.maximum(_blur(maps[3], WIDTH_SMOOTHING), np.float32(0.0)),
    )


def find_candidates(
    maps: GraspMaps, *, count: int = 16, distance: int = 6, threshold: float = 0.05
) -> Candidates:
    """The local maxima of the quality.

    Args:
        maps: smoothed maps.
        count: how many to give at most.
        distance: no better pixel lies within this of a maximum, along u or v [px].
        threshold: least quality; nor less than a tenth of the best.
    """
    quality = maps.quality
    neighbourhood = np.ones((2 * distance + 1, 2 * distance + 1), dtype=np.uint8)
    peak = quality >= cv2.dilate(quality, neighbourhood)
    peak &= quality > max(threshold, 0.1 * float(quality.max()))
    v, u = (found.astype(np.int64) for found in np.nonzero(peak))
    order = np.argsort(-quality[v, u], kind="stable")[:count]
    v, u = v[order], u[order]
    return Candidates(
        pixel=np.stack([u + _vertex(quality, v, u, 0, 1), v + _vertex(quality, v, u, 1, 0)], 1),
        angle=maps.angle[v, u].astype(float),
        width=maps.width[v, u].astype(float),
        quality=quality[v, u].astype(float),
    )


def _vertex(values: Image, v: Indices, u: Indices, dv: int, du: int) -> Array:
    """Offset of the top of the parabola through each peak and its neighbours, within half a px."""
    padded = np.pad(values, 1, mode="edge").astype(float)
    v, u = v + 1, u + 1
    before, here, after = padded[v - dv, u - du], padded[v, u], padded[v + dv, u + du]
    curvature = before - 2.0 * here + after
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = np.where(curvature < 0.0, 0.5 * (before - after) / curvature, 0.0)
    return np.clip(offset, -0.5, 0.5)


def _blur(image: Image, sigma: float) -> Image:
    return np.asarray(cv2.GaussianBlur(image, (0, 0), sigma), dtype=np.float32)
