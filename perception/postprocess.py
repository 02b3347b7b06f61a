"""From a network's maps to a few candidate grasps in the image.

GG-CNN's angle is never smoothed itself, because it jumps by half a turn; its cosine and sine are.
The angle-bin network's maps are smoothed along the directions too, around the circle that they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from perception.arrays import Array, Image, Indices, Mask
from perception.maps import BINS, SIZE, STRIDE, WIDTH_SCALE

SMOOTHING = 2.0
"""Standard deviation of the blur of quality, cosine and sine [px]."""
WIDTH_SMOOTHING = 1.0
"""Standard deviation of the blur of the width [px]."""


BIN_SMOOTHING = 0.7
"""Standard deviation of the blur of the quality of each closing direction [cells]."""


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


def bin_candidates(
    answer: Image,
    allowed: Mask,
    *,
    count: int = 16,
    distance: int = 2,
    threshold: float = 0.03,
) -> tuple[Candidates, Image]:
    """The local maxima over place and closing direction.

    Args:
        answer: (n, n, 2 BINS) quality, 0 to 1, and width of each direction.
        allowed: (n, n) where a grasp may be.
        count: how many to give at most.
        distance: no better cell lies within this of a maximum, nor a better direction next to its
            own [cells].
        threshold: least quality; nor less than a twentieth of the best.

    Returns:
        The candidates, and the (SIZE, SIZE) quality of the best direction everywhere.
    """
    quality_of_all = np.zeros(allowed.shape, dtype=np.float32)
    rows, columns = (np.flatnonzero(allowed.any(axis=axis)) for axis in (1, 0))
    if len(rows) == 0:
        empty = np.zeros(0)
        nothing = Candidates(pixel=np.zeros((0, 2)), angle=empty, width=empty, quality=empty)
        return nothing, np.zeros((SIZE, SIZE), dtype=np.float32)
    part = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    likely = np.ascontiguousarray(answer[part][..., :BINS])
    quality: Image = np.asarray(cv2.GaussianBlur(likely, (0, 0), BIN_SMOOTHING), dtype=np.float32)
    quality = np.float32(0.5) * quality + np.float32(0.25) * _both_neighbours(quality, np.add)
    quality *= allowed[part][..., None]
    best = quality.max(axis=2)
    quality_of_all[part] = best
    # Dilation looks at one map at a time, so directions are compared by hand.
    square = np.ones((2 * distance + 1, 2 * distance + 1), dtype=np.uint8)
    nearby = np.asarray(cv2.dilate(quality, square), dtype=np.float32)
    highest = np.maximum(nearby, _both_neighbours(nearby, np.maximum))
    peak = (quality >= highest) & (quality > max(threshold, 0.05 * float(best.max())))
    v, u, k = (found.astype(np.int64) for found in np.nonzero(peak))
    order = np.argsort(-quality[v, u, k], kind="stable")[:count]
    v, u, k = v[order], u[order], k[order]
    here = quality[v, u, k].astype(float)
    turn = _offset(quality[v, u, k - 1], here, quality[v, u, (k + 1) % BINS])
    maps: Image = np.ascontiguousarray(quality.transpose(2, 0, 1)[k], dtype=np.float32)
    cell = np.stack([u + _vertex(maps, v, u, 0, 1), v + _vertex(maps, v, u, 1, 0)], axis=1)
    cell += [columns[0], rows[0]]
    widths = answer[part][v, u, BINS + k].astype(float)
    candidates = Candidates(
        pixel=STRIDE * cell + (STRIDE - 1) / 2.0,
        angle=-(k + turn) * (np.pi / BINS),  # the network counts against v
        width=WIDTH_SCALE * np.maximum(widths, 0.0),
        quality=here,
    )
    enlarged = cv2.resize(quality_of_all, (SIZE, SIZE), interpolation=cv2.INTER_LINEAR)
    return candidates, np.asarray(enlarged, dtype=np.float32)


def _both_neighbours(maps: Image, joined: np.ufunc) -> Image:
    """The maps of the next and of the last direction, joined; directions are a circle."""
    neighbours = np.empty_like(maps)
    joined(maps[..., 2:], maps[..., :-2], out=neighbours[..., 1:-1])
    joined(maps[..., 1], maps[..., -1], out=neighbours[..., 0])
    joined(maps[..., 0], maps[..., -2], out=neighbours[..., -1])
    return neighbours


def _vertex(values: Image, v: Indices, u: Indices, dv: int, du: int) -> Array:
    """Offset of the top of each peak along v or u, within half a pixel.

    Args:
        values: (rows, columns), or (N, rows, columns) with a map for each peak.
        v: (N,) rows of the peaks.
        u: (N,) columns.
        dv: 1 to look along v, else 0.
        du: 1 to look along u, else 0.
    """
    rows, columns = values.shape[-2:]
    which = (np.arange(len(v)),) if values.ndim == 3 else ()

    def at(step: int) -> Array:
        row = np.clip(v + step * dv, 0, rows - 1)
        column = np.clip(u + step * du, 0, columns - 1)
        found: Array = values[(*which, row, column)].astype(float)
        return found

    return _offset(at(-1), at(0), at(1))


def _offset(before: Array | Image, here: Array | Image, after: Array | Image) -> Array:
    """Where the parabola through three neighbours has its top, within half a step of the middle."""
    before, here, after = (np.asarray(each, dtype=float) for each in (before, here, after))
    curvature = before - 2.0 * here + after
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = np.where(curvature < 0.0, 0.5 * (before - after) / curvature, 0.0)
    return np.asarray(np.clip(offset, -0.5, 0.5))


def _blur(image: Image, sigma: float) -> Image:
    return np.asarray(cv2.GaussianBlur(image, (0, 0), sigma), dtype=np.float32)
