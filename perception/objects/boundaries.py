"""Candidate boundaries between touching objects: cuts across a connected blob, and their features.

A boundary runs from a concave corner of the outline to another one, or straight on along an edge,
or round what is higher than a level.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import cv2
import numpy as np
import numpy.typing as npt

from config.arrays import Array, Image, Mask

Parts: TypeAlias = tuple[Mask, Mask]

SMALLEST = 1.0e-4  # both sides of a boundary cover at least this [m^2]
_OF_A_PART = ("area", "length", "width", "height", "beside", "fill", "solidity", "seam off middle")
BOUNDARY_FEATURES = (
    *(f"smaller part: {name}" for name in _OF_A_PART),
    *(f"larger part: {name}" for name in _OF_A_PART),
    "length",
    "height",
    "gap",
    "solidity",
)
"""Features of a boundary, in this order."""

_OUTLINE = 2.0  # tolerance of the polygon of an outline [cells]
_INWARD = np.radians(25.0)  # smallest turn of a concave corner ...
_NOTCH = 3.0  # ... and how deep it is: a straight edge is ragged by noise [cells]
_CORNERS = 12  # the deepest, between which boundaries run; the others may be the rim's noise
_BEYOND = 1.5  # by which a boundary goes on beyond its corner [cells]
_LOWEST, _LEVELS = 0.012, 0.004  # level of the first boundary around what is higher, and steps [m]
_PROMINENT = 0.006  # how far a part rises over a level that divides: noise and tilt do less [m]
_HIGH = 90.0  # percentile of the heights of a side
_SQUARE = np.ones((3, 3), np.uint8)
_BESIDE = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (7, 7))  # neighbourhood of a boundary


@dataclass(frozen=True, kw_only=True, eq=False)
class Blob:
    """A connected region, seen from straight above."""

    above: Image  # (rows, columns) heights over the floor [m]; 0 where none was measured
    cells: Mask  # (rows, columns) what it covers
    cell: float  # side of a cell [m]


def candidate_boundaries(blob: Blob) -> Iterator[Parts]:
    """Both sides of every candidate boundary."""
    least = SMALLEST / blob.cell**2
    for parts in (*_between_corners(blob.cells), *_around_heights(blob)):
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
    """Concave corner (x, y) [cells] and the directions in which its two edges go on inside."""
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
    hull = cv2.convexHull(outline)
    concave = np.flatnonzero(turn < -_INWARD).tolist()
    depth = {i: cv2.pointPolygonTest(hull, polygon[i].tolist(), measureDist=True) for i in concave}
    deepest = sorted(concave, key=lambda i: -depth[i])[:_CORNERS]
    return [
        (polygon[i].astype(float), _unit(into[i]), _unit(-out[i]))
        for i in sorted(deepest)
        if depth[i] >= _NOTCH
    ]


def _unit(vector: npt.NDArray[np.floating]) -> Array:
    return np.asarray(vector / max(float(np.linalg.norm(vector)), 1e-6), dtype=float)


def _far_side(cells: Mask, corner: Array, along: Array) -> Array | None:
    """Where a straight line from a corner leaves the blob, (x, y) [cells]; None if nowhere.

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
    """The two largest parts on both sides of a line (x, y) [cells], if it separates any."""
    drawn = cells.astype(np.uint8)
    first, last = (tuple(int(each) for each in np.rint(point)) for point in (begin, end))
    cv2.line(drawn, first, last, 0, 1)
    count, number, figures, _ = cv2.connectedComponentsWithStats(drawn, connectivity=4)
    if count > 2:
        one, other = np.argsort(-figures[1:, cv2.CC_STAT_AREA])[:2] + 1
        yield _nearer(cells, number == one, number == other)


def _around_heights(blob: Blob) -> Iterator[Parts]:
    """What is higher than a level and the rest, and the two largest of what is higher."""
    without_holes = cv2.morphologyEx(blob.above, cv2.MORPH_CLOSE, _SQUARE)
    above = np.where(blob.above > 0.0, blob.above, without_holes)
    for level in np.arange(_LOWEST, float(above.max()), _LEVELS):
        high = cv2.morphologyEx((above > level).astype(np.uint8), cv2.MORPH_OPEN, _SQUARE)
        tops = [
            top
            for top in largest_parts(high > 0, SMALLEST / blob.cell**2)
            if _percentile(blob, top, _HIGH) > level + _PROMINENT
        ]
        if len(tops) > 1:
            yield _nearer(blob.cells, tops[0], tops[1])
        if tops:
            around = blob.cells & ~(cv2.dilate(high, _SQUARE) > 0)
            clean = cv2.morphologyEx(around.astype(np.uint8), cv2.MORPH_OPEN, _SQUARE) > 0
            rest = largest_parts(clean, 1.0)
            if rest:
                yield blob.cells & ~rest[0], rest[0]


def largest_parts(mask: Mask, least: float) -> list[Mask]:
    """Connected parts of a mask that are not too small [cells], the largest first."""
    _, number, figures, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    areas = figures[1:, cv2.CC_STAT_AREA]
    return [number == one + 1 for one in np.argsort(-areas) if areas[one] > least]


def _nearer(cells: Mask, one: Mask, other: Mask) -> Parts:
    """The cells of a blob, divided by which of two parts of it is nearer."""
    to_one, to_other = (
        cv2.distanceTransform((~part).astype(np.uint8), cv2.DIST_L2, 5) for part in (one, other)
    )
    nearer: Mask = np.asarray(to_one <= to_other)
    return cells & nearer, cells & ~nearer


def boundary_features(blob: Blob, parts: Parts) -> Array:
    """(F,) `BOUNDARY_FEATURES` of the boundary between two parts of a blob.

    Lengths and heights are in m, areas in m^2; *beside* is the height of a part beside the
    boundary, *fill* its share of its bounding rectangle, *solidity* of its convex hull, *gap* the
    share of the boundary without a height.
    """
    smaller, larger = sorted(parts, key=np.count_nonzero)
    near = {id(part): cv2.dilate(part.astype(np.uint8), _SQUARE) > 0 for part in parts}
    boundary = (near[id(smaller)] & larger) | (near[id(larger)] & smaller)
    around = cv2.dilate(boundary.astype(np.uint8), _BESIDE) > 0
    return np.array(
        [
            *_measure_part(blob, smaller, boundary, around),
            *_measure_part(blob, larger, boundary, around),
            boundary.sum() / 2.0 * blob.cell,
            _percentile(blob, boundary, 50.0),
            float(np.mean(blob.above[boundary] <= 0.0)) if boundary.any() else 0.0,
            np.count_nonzero(blob.cells) / _hull(blob.cells),
        ]
    )


def _measure_part(blob: Blob, part: Mask, boundary: Mask, around: Mask) -> list[float]:
    """The features `_OF_A_PART` of one part."""
    area = int(np.count_nonzero(part))
    cells = np.argwhere(part)
    middle, edges, _ = cv2.minAreaRect(cells.astype(np.float32))
    long, short = max(edges) + 1.0, min(edges) + 1.0
    meets = np.argwhere(boundary).mean(axis=0) if boundary.any() else np.array(middle)
    return [
        area * blob.cell**2,
        long * blob.cell,
        short * blob.cell,
        _percentile(blob, part, _HIGH),
        _percentile(blob, part & around & ~boundary, 50.0),
        area / (long * short),
        area / _hull(part),
        float(np.linalg.norm(meets - middle)) * blob.cell,
    ]


def _percentile(blob: Blob, where: Mask, percent: float) -> float:
    """Of the measured heights in a mask [m]; 0 without any."""
    heights = blob.above[where & (blob.above > 0.0)]
    return float(np.percentile(heights, percent)) if len(heights) else 0.0


def _hull(part: Mask) -> float:
    """Area of the convex hull of cells, their halves at its rim included [cells]."""
    hull = cv2.convexHull(np.argwhere(part).astype(np.int32))
    return float(cv2.contourArea(hull) + cv2.arcLength(hull, closed=True) / 2.0 + 1.0)
