"""Where two things that touch may meet: seams across a piece that hangs together.

A seam runs from an inward corner of the outline to another one, or straight on along an edge, or
round what is higher than a level. Each is measured by a dozen numbers (`BOUNDARY_FEATURES`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import cv2
import numpy as np
import numpy.typing as npt

from perception.frame import Array, Image, Mask

Parts: TypeAlias = tuple[Mask, Mask]

SMALLEST = 1.0e-4
"""Both sides of a seam cover at least this [m^2]."""
_OF_A_PART = ("area", "length", "width", "height", "beside", "fill", "solidity", "seam off middle")
BOUNDARY_FEATURES = (
    *(f"smaller part: {name}" for name in _OF_A_PART),
    *(f"larger part: {name}" for name in _OF_A_PART),
    "length",
    "height",
    "gap",
    "solidity",
)
"""What is measured of a seam, in this order."""

_OUTLINE = 2.0  # an outline is taken for a polygon that is so near to it [cells]
_INWARD = np.radians(25.0)  # a corner that turns inwards by less is none
_BEYOND = 1.5  # a seam goes on beyond its corner by so much [cells]
_LOWEST, _LEVELS = 0.012, 0.004  # level of the first seam around what is higher, and steps [m]
_HIGH = 90.0  # percentile of the heights of a side
_SQUARE = np.ones((3, 3), np.uint8)
_BESIDE = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (7, 7))  # of a seam, what is beside it


@dataclass(frozen=True, kw_only=True, eq=False)
class Blob:
    """Something that hangs together, seen from straight above."""

    above: Image
    """(rows, columns) heights over the floor [m]; 0 where none was measured."""
    cells: Mask
    """(rows, columns) what it covers."""
    cell: float
    """Side of a cell [m]."""


def candidate_boundaries(piece: Blob) -> Iterator[Parts]:
    """Both sides of every seam that is worth a look."""
    least = SMALLEST / piece.cell**2
    for parts in (*_between_corners(piece.cells), *_around_heights(piece)):
        if min(int(part.sum()) for part in parts) >= least:
            yield parts


def _between_corners(cells: Mask) -> Iterator[Parts]:
    corners = _inward_corners(cells)
    for number, (corner, *edges) in enumerate(corners):
        for other, *_ in corners[number + 1 :]:
            further = _BEYOND * (other - corner) / max(float(np.linalg.norm(other - corner)), 1.0)
            yield from _cut(cells, corner - further, other + further)
        for edge in (*edges, _unit(edges[0] + edges[1])):
            end = _far_side(cells, corner, edge)
            if end is not None:
                yield from _cut(cells, corner - _BEYOND * edge, end)


def _inward_corners(cells: Mask) -> list[tuple[Array, Array, Array]]:
    """Corner (x, y) [cells] and the directions in which its two edges go on across the piece."""
    outlines, _ = cv2.findContours(cells.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    outline = max(outlines, key=cv2.contourArea)
    polygon = cv2.approxPolyDP(outline, _OUTLINE, closed=True)[:, 0].astype(np.float32)
    if len(polygon) < 4:
        return []
    turning = np.sign(cv2.contourArea(polygon, oriented=True))
    into = polygon - np.roll(polygon, 1, axis=0)
    out = np.roll(into, -1, axis=0)
    cross = turning * (into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0])
    turn = np.arctan2(cross, (into * out).sum(axis=1))
    return [
        (polygon[i].astype(float), _unit(into[i]), _unit(-out[i]))
        for i in np.flatnonzero(turn < -_INWARD)
    ]


def _unit(vector: npt.NDArray[np.floating]) -> Array:
    return np.asarray(vector / max(float(np.linalg.norm(vector)), 1e-6), dtype=float)


def _far_side(cells: Mask, corner: Array, along: Array) -> Array | None:
    """Where a straight line from a corner leaves the piece, (x, y) [cells]; None if nowhere.

    Near the corner itself it may be outside.
    """
    steps = corner + np.arange(1.0, sum(cells.shape), 0.7)[:, None] * along
    column, row = np.rint(steps).astype(np.int64).T
    rows, columns = cells.shape
    inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
    inside[inside] = cells[row[inside], column[inside]]
    begun = np.flatnonzero(inside[:4])
    if len(begun) == 0:
        return None
    left = np.flatnonzero(~inside[begun[0] :])
    last = begun[0] + (left[0] if len(left) else len(inside) - begun[0]) - 1
    end: Array = steps[last] + along
    return end


def _cut(cells: Mask, begin: Array, end: Array) -> Iterator[Parts]:
    """The two largest parts on both sides of a line (x, y) [cells], if it parts anything."""
    drawn = cells.astype(np.uint8)
    first, last = (tuple(int(each) for each in np.rint(point)) for point in (begin, end))
    cv2.line(drawn, first, last, 0, 1)
    count, number, figures, _ = cv2.connectedComponentsWithStats(drawn, connectivity=4)
    if count > 2:
        one, other = np.argsort(-figures[1:, cv2.CC_STAT_AREA])[:2] + 1
        yield _nearer(cells, number == one, number == other)


def _around_heights(piece: Blob) -> Iterator[Parts]:
    """What is higher than a level and the rest, and the two largest of what is higher."""
    for level in np.arange(_LOWEST, float(piece.above.max()), _LEVELS):
        high = cv2.morphologyEx((piece.above > level).astype(np.uint8), cv2.MORPH_OPEN, _SQUARE)
        tops = largest_parts(high > 0, SMALLEST / piece.cell**2)
        if len(tops) > 1:
            yield _nearer(piece.cells, tops[0], tops[1])
        if tops:
            around = piece.cells & ~(cv2.dilate(high, _SQUARE) > 0)
            clean = cv2.morphologyEx(around.astype(np.uint8), cv2.MORPH_OPEN, _SQUARE) > 0
            rest = largest_parts(clean, 1.0)
            if rest:
                yield piece.cells & ~rest[0], rest[0]


def largest_parts(mask: Mask, least: float) -> list[Mask]:
    """What hangs together in a mask and is not too small [cells], the largest first."""
    _, number, figures, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    areas = figures[1:, cv2.CC_STAT_AREA]
    return [number == one + 1 for one in np.argsort(-areas) if areas[one] > least]


def _nearer(cells: Mask, one: Mask, other: Mask) -> Parts:
    """The cells of a piece, parted by which of two parts of it is nearer."""
    to_one, to_other = (
        cv2.distanceTransform((~part).astype(np.uint8), cv2.DIST_L2, 5) for part in (one, other)
    )
    nearer: Mask = np.asarray(to_one <= to_other)
    return cells & nearer, cells & ~nearer


def boundary_features(piece: Blob, parts: Parts) -> Array:
    """(F,) `BOUNDARY_FEATURES` of the seam between two parts of a piece.

    Lengths and heights are in m, areas in m^2; *beside* is the height of a part beside the seam,
    *fill* how much of the rectangle around it a part fills, *solidity* how much of its convex
    hull, *gap* the share of the seam without a height.
    """
    smaller, larger = sorted(parts, key=np.count_nonzero)
    near = {id(part): cv2.dilate(part.astype(np.uint8), _SQUARE) > 0 for part in parts}
    seam = (near[id(smaller)] & larger) | (near[id(larger)] & smaller)
    around = cv2.dilate(seam.astype(np.uint8), _BESIDE) > 0
    return np.array(
        [
            *_measure_part(piece, smaller, seam, around),
            *_measure_part(piece, larger, seam, around),
            seam.sum() / 2.0 * piece.cell,
            _percentile(piece, seam, 50.0),
            float(np.mean(piece.above[seam] <= 0.0)) if seam.any() else 0.0,
            np.count_nonzero(piece.cells) / _hull(piece.cells),
        ]
    )


def _measure_part(piece: Blob, part: Mask, seam: Mask, around: Mask) -> list[float]:
    """Of one part what `_OF_A_PART` names."""
    area = int(np.count_nonzero(part))
    cells = np.argwhere(part)
    middle, edges, _ = cv2.minAreaRect(cells.astype(np.float32))
    long, short = max(edges) + 1.0, min(edges) + 1.0
    meets = np.argwhere(seam).mean(axis=0) if seam.any() else np.array(middle)
    return [
        area * piece.cell**2,
        long * piece.cell,
        short * piece.cell,
        _percentile(piece, part, _HIGH),
        _percentile(piece, part & around & ~seam, 50.0),
        area / (long * short),
        area / _hull(part),
        float(np.linalg.norm(meets - middle)) * piece.cell,
    ]


def _percentile(piece: Blob, where: Mask, percent: float) -> float:
    """Of the measured heights in a mask [m]; 0 without any."""
    heights = piece.above[where & (piece.above > 0.0)]
    return float(np.percentile(heights, percent)) if len(heights) else 0.0


def _hull(part: Mask) -> float:
    """Area of the convex hull of cells, their halves at its rim included [cells]."""
    hull = cv2.convexHull(np.argwhere(part).astype(np.int32))
    return float(cv2.contourArea(hull) + cv2.arcLength(hull, closed=True) / 2.0 + 1.0)
