"""Segmentation of the objects in a region by height, colour and shape.

Seen from straight above, whatever stands out of the floor is cut where the colour changes and where
the height jumps. Touching objects of one colour are split where a boundary is likely (`touching`).
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from pinocchio import SE3, exp3

from config.arrays import Array, Image, Indices, Mask
from perception.frame import ColourFrame, Colours, Workspace
from perception.objects.boundaries import largest_parts
from perception.objects.colours import colour_name
from perception.objects.detected_object import REACH, DetectedObject, DetectedObjects
from perception.objects.footprint import Footprint, Grid
from perception.objects.touching_objects import split_touching

LOWEST = 0.008  # smallest height of an object over the floor [m]
MARGIN = 0.006  # nothing this near to the sides counts: there may be walls [m]
SMALLEST = 1.0e-4  # a smaller area belongs to a neighbour, or is noise [m^2]
OTHER_COLOUR = 30.0  # smallest difference of red, green and blue between two objects, of 255
STEP = 0.025  # without colours, smallest difference of height between two objects [m]
CELL = 0.0015  # side of a cell of the grid, at least [m] ...
PIXELS = 1.25  # ... and this many pixels of the camera on the floor
BORDER = 3  # an object this near to the border may go on beyond it [px]
SAME = 0.65  # shared area of two views of one object; halves of an object share less
_SQUARE = np.ones((3, 3), dtype=np.uint8)


def segment_objects(
    frame: ColourFrame, workspace: Workspace, floor: float | None = None
) -> DetectedObjects | None:
    """The objects in a region, from the left to the right of the image; None without any depth.

    The camera looks down; objects stand on the floor of the workspace, which it shows at the height
    `floor` [m] where that is known.
    """
    what = raised_regions(frame, workspace, floor)
    if what is None or len(what.points) == 0:
        return None if what is None else DetectedObjects()
    grid = Grid.over(what.points, what.cell)
    of_point = split_touching(what.of_point, what.points, workspace.floor, what.cell)
    found = (
        _object(frame, workspace.floor, grid, what.raised, what.points, of_point == number)
        for number in np.unique(of_point[of_point > 0])
        if (of_point == number).sum() >= what.smallest
    )
    return DetectedObjects(sorted(found, key=lambda one: one.box))


@dataclass(frozen=True, kw_only=True, eq=False)
class RaisedRegions:
    """Connected regions above a floor; touching objects of one colour are not yet split."""

    raised: Mask  # (H, W) which pixels are above the floor
    points: Array  # (P, 3) of these pixels in odometry [m]
    of_point: Indices  # (P,) number of the region, from 1; 0 is too small
    cell: float  # side of the cells for its shape from above [m]
    smallest: int  # smallest number of pixels of an object


def raised_regions(
    frame: ColourFrame, workspace: Workspace, floor: float | None = None
) -> RaisedRegions | None:
    """Connected regions above the floor; None if there is no depth in the image."""
    valid = frame.cloud.valid
    if not valid.any():
        return None
    shown = workspace.floor if floor is None else floor
    raised, points = _raised(frame, workspace, shown + LOWEST)
    far = float(frame.oTc.translation[2]) - workspace.floor
    on_floor = far / frame.intrinsics.fx  # a pixel's side there [m]
    heights = np.zeros(raised.shape, dtype=np.float32)
    heights[raised] = points[:, 2]
    smallest = round(SMALLEST / on_floor**2)
    label = _without_crumbs(_labels(raised, ~valid, heights, frame.colour), raised, smallest)
    return RaisedRegions(
        raised=raised,
        points=points,
        of_point=label[raised],
        cell=max(CELL, PIXELS * on_floor),
        smallest=smallest,
    )


def _raised(frame: ColourFrame, workspace: Workspace, lowest: float) -> tuple[Mask, Array]:
    """Which pixels (H, W) are above a height [m] in the region, and their points (P, 3)."""
    v, u, points = frame.cloud.every(1)
    high = points[:, 2] > lowest
    v, u, points = v[high], u[high], points[high]
    inside = np.ones(len(points), dtype=np.bool_)
    for dx, dy in ((MARGIN, 0.0), (-MARGIN, 0.0), (0.0, MARGIN), (0.0, -MARGIN)):
        inside &= workspace.contains(points + np.array([dx, dy, 0.0]))
    raised = np.zeros(frame.cloud.valid.shape, dtype=np.bool_)
    raised[v[inside], u[inside]] = True
    return raised, points[inside]


def _labels(raised: Mask, missing: Mask, heights: Image, colours: Colours | None) -> Indices:
    """(H, W) numbers of connected regions of the image, from 1; 0 elsewhere.

    Where there are colours, pixels of one colour are connected whatever their depth, also through
    those that have none: the side of an object belongs to its top.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    nodes = raised if colours is None else raised | missing
    number = np.full(nodes.shape, -1, dtype=np.int32)
    count = int(nodes.sum())
    number[nodes] = np.arange(count)
    height = heights[nodes]
    colour = None if colours is None else colours[nodes].astype(np.int32)
    ones, others = [], []
    for one, other in ((number[:, :-1], number[:, 1:]), (number[:-1], number[1:])):
        both = (one >= 0) & (other >= 0)
        a, b = one[both], other[both]
        if colour is None:
            joined = np.abs(height[a] - height[b]) < STEP
        else:
            joined = ((colour[a] - colour[b]) ** 2).sum(axis=1) < OTHER_COLOUR**2
        ones.append(a[joined])
        others.append(b[joined])
    a, b = np.concatenate(ones), np.concatenate(others)
    graph = coo_array((np.ones(len(a), dtype=np.int8), (a, b)), shape=(count, count))
    _, parts = connected_components(graph, directed=False)
    label = np.zeros(nodes.shape, dtype=np.int64)
    label[nodes] = np.asarray(parts, dtype=np.int64) + 1
    return label


def _without_crumbs(label: Indices, raised: Mask, smallest: int) -> Indices:
    """The labels numbered anew, without regions of fewer raised pixels."""
    sizes = np.bincount(label[raised], minlength=int(label.max()) + 1)
    kept = sizes >= max(smallest, 1)
    kept[0] = False
    return np.where(kept, np.cumsum(kept), 0)[label]


def _object(
    frame: ColourFrame, floor: float, grid: Grid, raised: Mask, points: Array, mine: Mask
) -> DetectedObject:
    v, u = (index[mine] for index in np.nonzero(raised))
    rows, columns = frame.depth.shape
    box = (int(u.min()), int(v.min()), int(u.max()), int(v.max()))
    beyond = min(box[0], box[1], columns - 1 - box[2], rows - 1 - box[3])
    cells = grid.covered(points[mine])
    outline = grid.centres(_without_spurs(cells))
    (x, y), (one, other), angle = cv2.minAreaRect((outline - outline[0]).astype(np.float32))
    yaw = np.deg2rad(angle if one >= other else angle + 90.0)
    length, width = (float(edge) + grid.cell for edge in (max(one, other), min(one, other)))
    height = float(np.percentile(points[mine, 2], 98.0)) - floor
    middle = np.array([x + outline[0, 0], y + outline[0, 1], floor + height / 2.0])
    footprint, around = _footprints(cells, grid)
    colour = None if frame.colour is None else np.median(frame.colour[v, u], axis=0)
    return DetectedObject(
        seen_at=SE3(exp3(np.array([0.0, 0.0, yaw])), middle),
        size=(length, width, height),
        area=int(cells.sum()) * grid.cell**2,
        colour="" if colour is None else colour_name(*colour.tolist()),
        whole=beyond > BORDER,
        box=box,
        floor=floor,
        footprint=footprint,
        around=around,
    )


def _without_spurs(cells: Mask) -> Mask:
    """Cells without thin or separate parts: noise at the edge of objects."""
    image = cells.astype(np.uint8)
    opened = cv2.morphologyEx(image, cv2.MORPH_OPEN, _SQUARE)
    parts = largest_parts(opened > 0, 0.0)
    if not parts:
        return cells
    body: Mask = (cv2.dilate(parts[0].astype(np.uint8), _SQUARE) > 0) & cells
    return body


def _footprints(cells: Mask, grid: Grid) -> tuple[Footprint, Footprint]:
    """Of an object, and of what is around it."""
    far = round(REACH / grid.cell) + 1
    row, column = np.nonzero(cells)
    top, left = int(row.min()), int(column.min())
    part = np.pad(cells[top : row.max() + 1, left : column.max() + 1], far)
    origin = grid.origin + grid.cell * (np.array([left, top]) - far)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * far + 1, 2 * far + 1))
    wide = cv2.dilate(part.astype(np.uint8), disc).astype(np.bool_)
    return (
        Footprint(cells=part, origin=origin, cell=grid.cell),
        Footprint(cells=wide, origin=origin, cell=grid.cell),
    )


def consensus(frames: Sequence[DetectedObjects]) -> DetectedObjects:
    """The objects in more than half of several frames, from the left to the right of the image.

    Sizes and areas are medians; all else is as in the newest frame, which is the last.
    """
    groups: list[list[DetectedObject]] = []
    for one in (one for frame in reversed(frames) for one in frame):
        comparable = (group for group in groups if group[0].footprint.shared(one.footprint) >= SAME)
        if (group := next(comparable, None)) is None:
            groups.append([one])
        else:
            group.append(one)
    most = [_typical(group) for group in groups if 2 * len(group) > len(frames)]
    return DetectedObjects(sorted(most, key=lambda one: one.box))


def _typical(group: Sequence[DetectedObject]) -> DetectedObject:
    length, width, height = np.median([one.size for one in group], axis=0).tolist()
    return replace(
        group[0],
        size=(length, width, height),
        area=float(np.median([one.area for one in group])),
        colour=Counter(one.colour for one in group).most_common(1)[0][0],
    )
