"""Candidate grasps as local maxima of a network's output maps.

GG-CNN's cosine and sine maps are smoothed, not the angle, which wraps at half a turn. The maps of
the angle-bin network are also smoothed over the closing directions, which are periodic.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from perception.frame import Array, Image, Indices, Mask
from perception.grasps.candidates import Candidates
from perception.grasps.network_input import ANGLE_BINS, INPUT_SIZE, OUTPUT_STRIDE, WIDTH_SCALE

SMOOTHING = 2.0  # standard deviation of the blur of quality, cosine and sine [input px]
WIDTH_SMOOTHING = 1.0  # standard deviation of the blur of the width [input px]
BIN_SMOOTHING = 0.7  # standard deviation of the blur of each direction's quality [cells]

_COUNT = 16  # candidates at most
_APART, _BINS_APART = 6, 2  # no better pixel [px] or cell is within this of a maximum, along u or v
_LEAST, _BINS_LEAST = 0.05, 0.03  # smallest quality; also a share of the best is required


@dataclass(frozen=True, kw_only=True, eq=False)
class GraspMaps:
    """GG-CNN's output for every pixel, smoothed."""

    quality: Image  # (300, 300) 0 where no grasp is allowed
    angle: Image  # (300, 300) closing direction, from u towards v, in (-π/2, π/2] [rad]
    width: Image  # (300, 300) opening [input px]


def grasp_maps(maps: Image, allowed: Mask) -> GraspMaps:
    """Smooth the raw maps of GG-CNN (4, 300, 300): quality, cosine, sine, width / 150 px."""
    quality, cosine, sine = (_blur(layer, SMOOTHING) for layer in maps[:3])
    return GraspMaps(
        quality=np.where(allowed, np.clip(quality, 0.0, 1.0), 0.0).astype(np.float32),
        angle=np.float32(-0.5) * np.arctan2(sine, cosine),  # the network measures it against v
        width=np.float32(WIDTH_SCALE)
        * np.maximum(_blur(maps[3], WIDTH_SMOOTHING), np.float32(0.0)),
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
    return Candidates(
        pixel=np.stack([u + _subpixel(quality, v, u, 0, 1), v + _subpixel(quality, v, u, 1, 0)], 1),
        angle=maps.angle[v, u].astype(float),
        width=maps.width[v, u].astype(float),
        quality=quality[v, u].astype(float),
    )


def bin_candidates(output: Image, allowed: Mask) -> tuple[Candidates, Image]:
    """Local maxima over position and closing direction, where a grasp is allowed (n, n).

    `output` (n, n, 2 ANGLE_BINS) are quality, 0 to 1, and width of each direction. Also returns the
    (INPUT_SIZE, INPUT_SIZE) quality of the best direction.
    """
    quality_of_all = np.zeros(allowed.shape, dtype=np.float32)
    rows, columns = (np.flatnonzero(allowed.any(axis=axis)) for axis in (1, 0))
    if len(rows) == 0:
        empty = np.zeros(0)
        nothing = Candidates(pixel=np.zeros((0, 2)), angle=empty, width=empty, quality=empty)
        return nothing, np.zeros((INPUT_SIZE, INPUT_SIZE), dtype=np.float32)
    part = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    likely = np.ascontiguousarray(output[part][..., :ANGLE_BINS])
    quality: Image = np.asarray(cv2.GaussianBlur(likely, (0, 0), BIN_SMOOTHING), dtype=np.float32)
    quality = np.float32(0.5) * quality + np.float32(0.25) * _both_neighbours(quality, np.add)
    quality *= allowed[part][..., None]
    best = quality.max(axis=2)
    quality_of_all[part] = best
    # cv2.dilate treats each map separately, so adjacent directions are compared here.
    neighbourhood = np.ones((2 * _BINS_APART + 1, 2 * _BINS_APART + 1), dtype=np.uint8)
    nearby = np.asarray(cv2.dilate(quality, neighbourhood), dtype=np.float32)
    highest = np.maximum(nearby, _both_neighbours(nearby, np.maximum))
    peak = (quality >= highest) & (quality > max(_BINS_LEAST, 0.05 * float(best.max())))
    v, u, k = np.unravel_index(np.flatnonzero(peak), peak.shape)
    order = np.argsort(-quality[v, u, k], kind="stable")[:_COUNT]
    v, u, k = v[order], u[order], k[order]
    here = quality[v, u, k].astype(float)
    turn = _parabola_vertex(quality[v, u, k - 1], here, quality[v, u, (k + 1) % ANGLE_BINS])
    maps: Image = np.ascontiguousarray(quality.transpose(2, 0, 1)[k], dtype=np.float32)
    cell = np.stack([u + _subpixel(maps, v, u, 0, 1), v + _subpixel(maps, v, u, 1, 0)], axis=1)
    cell += [columns[0], rows[0]]
    widths = output[part][v, u, ANGLE_BINS + k].astype(float)
    candidates = Candidates(
        pixel=OUTPUT_STRIDE * cell + (OUTPUT_STRIDE - 1) / 2.0,
        angle=-(k + turn) * (np.pi / ANGLE_BINS),  # the network measures it against v
        width=WIDTH_SCALE * np.maximum(widths, 0.0),
        quality=here,
    )
    enlarged = cv2.resize(quality_of_all, (INPUT_SIZE, INPUT_SIZE), interpolation=cv2.INTER_LINEAR)
    return candidates, np.asarray(enlarged, dtype=np.float32)


def _both_neighbours(maps: Image, combined: np.ufunc) -> Image:
    """The maps of the next and the previous direction, combined; directions are periodic."""
    neighbours = np.empty_like(maps)
    combined(maps[..., 2:], maps[..., :-2], out=neighbours[..., 1:-1])
    combined(maps[..., 1], maps[..., -1], out=neighbours[..., 0])
    combined(maps[..., 0], maps[..., -2], out=neighbours[..., -1])
    return neighbours


def _subpixel(values: Image, v: Indices, u: Indices, dv: int, du: int) -> Array:
    """Subpixel offset of each peak along v or u, by a parabola.

    `values` is (rows, columns), or (N, rows, columns) with one map per peak.
    """
    rows, columns = values.shape[-2:]
    which = (np.arange(len(v)),) if values.ndim == 3 else ()

    def at(step: int) -> Array:
        row = np.clip(v + step * dv, 0, rows - 1)
        column = np.clip(u + step * du, 0, columns - 1)
        found: Array = values[(*which, row, column)].astype(float)
        return found

    return _parabola_vertex(at(-1), at(0), at(1))


def _parabola_vertex(before: Array | Image, here: Array | Image, after: Array | Image) -> Array:
    """Vertex of the parabola through three neighbours, at most half a step from the middle."""
    before, here, after = (np.asarray(each, dtype=float) for each in (before, here, after))
    curvature = before - 2.0 * here + after
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = np.where(curvature < 0.0, 0.5 * (before - after) / curvature, 0.0)
    return np.asarray(np.clip(offset, -0.5, 0.5))


def _blur(image: Image, sigma: float) -> Image:
    return np.asarray(cv2.GaussianBlur(image, (0, 0), sigma), dtype=np.float32)
