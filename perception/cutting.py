"""Two things of one colour that touch, cut apart: at necks, at valleys and at steps of height.

Two boxes of one colour and height, face to face, stay one: nothing in one image says more.
"""

from __future__ import annotations

import cv2
import numpy as np

from perception.arrays import Array, Image, Indices, Mask
from perception.grid import Grid

NECK = 0.42
"""What is narrower somewhere than this share of the narrower of both sides is two things."""
_LEAST_PART = 0.006
"""Both sides are at least twice this wide [m]."""
VALLEY = 0.62
"""A valley between two heights that is lower than this share of the lower one parts two things."""
STEP = 0.025
"""So does a step of this height [m] ..."""
_SLOPE = 0.5
"""... if what lies between covers less than this share of the smaller part."""
_SHADOW = 0.006
"""Gaps that are not wider may be hidden from the camera [m]."""
_LEVELS = 0.004
"""Between the levels at which heights are looked at [m]."""
_LEAST_TOP = 1.5e-4
"""Both parts cover at least this [m^2]."""
_LEAST_FOOT = 2.0e-4
"""What is lower covers at least this, less its rim [m^2]."""
_RIM = 0.003
"""Sides that are not quite upright are not wider than this [m]."""


def cut_at_necks(label: Indices, on_floor: float) -> Indices:
    """The same with pieces cut in two where they are much narrower than on both sides.

    Args:
        label: (H, W) numbers from 1.
        on_floor: side of a pixel there [m].
    """
    cut = np.zeros_like(label)
    count = 0
    for number in range(1, int(label.max()) + 1):
        parts = _parts_at_necks(label == number, _LEAST_PART / on_floor)
        cut[parts > 0] = parts[parts > 0] + count
        count += int(parts.max())
    return cut


def _parts_at_necks(piece: Mask, least: float) -> Indices:
    """(H, W) numbers from 1 of the parts of one piece that necks join."""
    row, column = np.nonzero(piece)
    window = np.s_[row.min() : row.max() + 1, column.min() : column.max() + 1]
    small = cv2.morphologyEx(
        np.pad(piece[window], 2).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)
    )
    depth = cv2.distanceTransform(small, cv2.DIST_L2, 5)[2:-2, 2:-2]
    whole: Indices = piece.astype(np.int64)
    for level in np.arange(1.0, float(depth.max()), 1.0):
        count, cores = cv2.connectedComponents((depth > level).astype(np.uint8), connectivity=8)
        widths = [(number, float(depth[cores == number].max())) for number in range(1, count)]
        large = [n for n, width in widths if width > least and level < NECK * width]
        if len(large) > 1:
            whole[window] = _nearest_core(piece[window], np.asarray(cores, np.int64), large)
            break
    return whole


def _nearest_core(piece: Mask, cores: Indices, numbers: list[int]) -> Indices:
    """Each cell of a piece belongs to the core that is nearest to it."""
    distances = [
        cv2.distanceTransform((cores != number).astype(np.uint8), cv2.DIST_L2, 5)
        for number in numbers
    ]
    return np.where(piece, np.argmin(distances, axis=0) + 1, 0)


def cut_at_heights(of_point: Indices, points: Array, floor: float, cell: float) -> Indices:
    """Numbers (P,) of points, from 1; pieces with a valley or a step in them are cut in two.

    Args:
        of_point: numbers from 1; 0 belongs to nothing.
        points: (P, 3) in the world [m].
        floor: what things stand on [m].
        cell: side of the cells that heights are compared in [m].
    """
    cut = of_point.copy()
    open_numbers = [int(n) for n in np.unique(of_point) if n > 0]
    newest = max(open_numbers, default=0)
    while open_numbers:
        number = open_numbers.pop()
        mine = cut == number
        own = points[mine] - np.array([0.0, 0.0, floor])
        piece = Grid.over(own, cell)
        parts = _parts_at_heights(piece.heights(own), piece.covered(own), cell)
        if parts is None:
            continue
        row, column = piece.cells_of(own)
        is_other = parts[row, column] == 2
        if not is_other.any() or is_other.all():
            continue
        newest += 1
        cut[np.flatnonzero(mine)[is_other]] = newest
        open_numbers += [number, newest]
    return cut


def _parts_at_heights(above: Image, cells: Mask, cell: float) -> Indices | None:
    """(rows, columns) 1 or 2 for each cell of a piece with two parts; None if it has one.

    Args:
        above: heights over the floor [m].
        cells: of the piece.
        cell: side of one [m].
    """
    top, foot = (area / cell**2 for area in (_LEAST_TOP, _LEAST_FOOT))
    highest = float(np.percentile(above[above > 0.0], 98.0))
    above = _without_shadows(above, cells, round(_SHADOW / cell))
    rim = np.ones((2 * round(_RIM / cell) + 1,) * 2, np.uint8)
    for level in np.arange(0.01, highest, _LEVELS):
        high = _opened(above > level)
        count, tops = cv2.connectedComponents(high.astype(np.uint8), connectivity=8)
        large = [n for n in range(1, count) if (tops == n).sum() >= top]
        peaks = [float(np.percentile(above[tops == n], 95.0)) for n in large]
        if len(large) > 1:
            first, second = sorted(range(len(large)), key=lambda i: -peaks[i])[:2]
            if level < VALLEY * peaks[second]:
                return _nearest_core(cells, tops.astype(np.int64), [large[first], large[second]])
        low = cells & (above > 0.0) & (above < level - STEP)
        low = cv2.erode(low.astype(np.uint8), rim) > 0
        between = cells & (above >= level - STEP) & (above <= level)
        smaller = min(int(high.sum()), int(low.sum()))
        if large and low.sum() >= foot and between.sum() < _SLOPE * smaller:
            return _nearest_core(cells, np.where(high, 1, np.where(low, 2, 0)), [1, 2])
    return None


def _without_shadows(above: Image, cells: Mask, width: int) -> Image:
    """The same with narrow gaps, in which a higher part hides the floor, as high as their sides."""
    kernel = np.ones((width, width), np.uint8)
    padded = np.pad(cells, width).astype(np.uint8)
    closed = cv2.morphologyEx(padded, cv2.MORPH_CLOSE, kernel)[width:-width, width:-width] > 0
    sides = cv2.morphologyEx(above, cv2.MORPH_CLOSE, kernel)
    return np.where(closed & (above == 0.0), sides, above).astype(np.float32)


def _opened(mask: Mask) -> Mask:
    kernel = np.ones((3, 3), np.uint8)
    opened: Mask = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, kernel) > 0
    return opened
