"""Height map of the floor of a region, accumulated from depth frames.

Heights are relative to where each frame shows the floor by the furniture around it, and then to
the plane that all of them show, so that an error of the camera mount does not count as an object,
unless that plane is higher than the floor can be. The smallest height that counts follows from
their noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil, hypot, inf
from typing import NamedTuple

import cv2
import numpy as np
from pinocchio import SE3

from config.arrays import Array, Mask
from config.poses import OdometryPose
from perception.frame import Frame
from perception.objects.detected_object import DetectedObject
from perception.registration import UNKNOWN_COVER, Place

WALL_MARGIN = 0.008  # smallest distance of a grasp or an object to the sides of the workspace [m]
_NEAR_FLOOR = 0.015  # largest height of the floor over its expected one [m]
_MAP_ERROR = 0.005  # of heights on the map [m]
_BEYOND = 0.02  # what stands outside, but by less than the place is uncertain, counts to here [m]
_BELOW = 0.03  # noise may put the floor this far below [m]
_ROUNDS = (True, True, True, False, False, False)  # of fitting the floor: to its lower half?
_LEAST_CELLS = 50  # of a floor that can be fitted
_SIGMAS = 6.0  # standard deviations of the floor's noise that an object exceeds
_LOWEST = 0.0025  # smallest height that counts in a cell [m] ...
_LOWEST_WIDE = 0.0015  # ... and in all the cells of a window [m]
_WINDOW = 5  # side of such a window [cells]
_OBJECT = 3.0e-4  # a smaller area may be a part of another object [m^2]
_BETWEEN = 0.4  # share of measured neighbours that makes a cell measured
_GAP = 0.006  # a narrower gap between measured cells hides no object [m]
_STRIP = 0.025  # beside the sides walls hide the floor from one imager [m]
_STRIP_CELLS = 4  # a narrower strip hides no object


_UNSEEN = Place(SE3.Identity(), np.zeros(2), 0.0, inf, inf)  # before the first frame


class Segment(NamedTuple):
    """An object in the region, or a part of it that was not seen, from above."""

    centre: Array  # (3,) on the floor of the region, in odometry [m]
    area: float  # seen from above [m^2]


@dataclass(frozen=True, eq=False)
class _Judged:
    occupied: Mask  # (X, Y) cells with an object
    lowest: float  # smallest height that counts [m]
    floor: float  # height of the floor over its nominal one [m]


class RegionMap:
    """Square cells of the floor of a region, as seen from above.

    Args:
        oTr: centre of the upright box of the region, in odometry.
        size: (3,) full edge lengths [m].
        cell: side of a cell [m].
        stride: every n-th pixel of a frame is used, along rows and columns; of the next, others.

    What stands within `WALL_MARGIN` of a side is left out, less the least tolerance of where the
    frames show the region: it may stand inside.
    """

    def __init__(
        self,
        oTr: OdometryPose,
        size: Array,
        cell: float = 0.003,
        stride: int = 2,
    ) -> None:
        self.oTr = oTr
        """Its centre where the newest frame shows it, in odometry."""
        self._size, self._cell, self._stride = size, cell, stride
        self._half = size[:2] / 2.0 - WALL_MARGIN
        inner = np.maximum(np.ceil(2.0 * self._half / cell).astype(int), 1)
        around = ceil(_BEYOND / cell)
        self._inner = tuple(slice(around, around + n) for n in inner)
        shape = inner + 2 * around
        self._corner = -self._half - around * cell  # (2,) of the grid, in the region [m]
        self._count = np.zeros(shape)
        self._sum = np.zeros(shape)
        self._best = _UNSEEN
        self._aside = np.full(2, _BEYOND)  # least tolerance of a frame, along the edges [m]
        self.frames = 0

    def add(self, frame: Frame, place: Place | None = None) -> None:
        """Add a frame, and where it shows the region; None is exactly at `oTr`."""
        place = place or Place(self.oTr, np.zeros(2), 0.0, UNKNOWN_COVER, UNKNOWN_COVER)
        self._best = min(self._best, place, key=lambda one: (one.cover, one.floor_tolerance))
        every = self._stride
        row = self.frames % every
        column = (row + self.frames // every) % every  # every pixel has its turn
        points = frame.cloud.every(every, row, column).points
        local = (points - place.oTr.translation) @ place.oTr.rotation
        height = local[:, 2] + self._size[2] / 2.0 - place.floor
        half = self._within(place.tolerance)
        inside = (np.abs(local[:, :2]) < half).all(axis=1)
        inside &= (height > -_BELOW) & (height < self._size[2])
        x, y = ((local[inside, :2] - self._corner) / self._cell).astype(int).T
        shape, cells = self._count.shape, x * self._count.shape[1] + y
        self._count += np.bincount(cells, minlength=self._count.size).reshape(shape)
        self._sum += np.bincount(cells, height[inside], self._count.size).reshape(shape)
        self.frames += 1
        self.oTr = place.oTr
        self.__dict__.pop("_judged", None)

    def _within(self, tolerance: Array) -> Array:
        """Half of the size (2,) that counts by the most certain frame [m].

        What others have shown beyond that is forgotten. `tolerance` (2,) is of the newest frame.
        """
        least = np.minimum(self._aside, tolerance)
        half: Array = self._half + least
        if (least < self._aside).any():
            self._aside = least
            x, y = (
                np.abs(corner + (np.arange(n) + 0.5) * self._cell) + 0.5 * self._cell > edge
                for corner, n, edge in zip(self._corner, self._count.shape, half, strict=True)
            )
            beyond = np.logical_or.outer(x, y)
            self._count[beyond] = self._sum[beyond] = 0.0
        return half

    @property
    def seen(self) -> float:
        """Share of the region that was seen, 0 to 1."""
        return 1.0 - float(self._is_hidden.mean())

    @property
    def _is_hidden(self) -> Mask:
        """(X, Y) cells of the region in gaps that are wide enough for an object.

        From a flat angle, pixels lie farther apart than cells: what lies among measured cells is
        measured.
        """
        hit = (self._count[self._inner] > 0).astype(np.float32)
        measured: Mask = (hit > 0.0) | (cv2.blur(hit, (3, 3)) > _BETWEEN)
        return _opened(~measured, max(1, round(_GAP / self._cell)))

    @property
    def lowest(self) -> float:
        """Smallest height over the floor that counts [m]; infinite if nothing was seen."""
        return self._judged.lowest

    @property
    def cover(self) -> float:
        """What lies flat over the whole floor is seen if it is higher than this [m]."""
        return self._tolerance + self._best.cover + max(0.0, self._judged.floor - self._best.floor)

    @property
    def _tolerance(self) -> float:
        """By how much the plane of the floor may be higher than it is expected [m]."""
        return hypot(self._best.floor_tolerance, _MAP_ERROR)

    @property
    def floor(self) -> float:
        """Height in odometry at which the frames show the floor [m]."""
        return float(self.oTr.translation[2] - self._size[2] / 2.0) + self._judged.floor

    def segments(self, smallest: float, beside: Sequence[DetectedObject] = ()) -> list[Segment]:
        """Every separate object that covers at least an area [m^2], beside known ones."""
        occupied = self._judged.occupied
        if beside:
            x, y = np.nonzero(occupied)
            cells = self._world(np.stack([x, y]))
            known = np.any([one.contains(cells) for one in beside], axis=0)
            occupied = occupied.copy()
            occupied[x[known], y[known]] = False
        return self._pieces(occupied, smallest)

    def fewest(self, smallest: float) -> int:
        """How many objects cover at least an area [m^2]: with a hole between, two may be one."""
        occupied = self._judged.occupied
        either = occupied.copy()
        either[self._inner] |= self._is_hidden
        image = occupied.astype(np.uint8)
        _, part, stats, _ = cv2.connectedComponentsWithStats(image, connectivity=4)
        large = stats[part, cv2.CC_STAT_AREA] * self._cell**2 >= smallest
        _, whole = cv2.connectedComponents(_closed(either).astype(np.uint8))
        return len(np.unique(np.asarray(whole)[occupied & large]))

    @property
    def pieces(self) -> list[Segment]:
        """Each at least one object: those with hardly a gap between may be one."""
        return self._pieces(_closed(self._judged.occupied), _OBJECT)

    def hidden(self, smallest: float, width: float = 0.0) -> list[Segment]:
        """Unseen parts of at least an area [m^2], in which an object may stand.

        Its shorter edge is at least `width` [m]; however it is turned, it covers a disc.
        """
        inner = _opened(self._is_hidden, max(1, int(width / self._cell)), cv2.MORPH_ELLIPSE)
        strip = round(_STRIP / self._cell)
        at_side = np.ones_like(inner)
        at_side[strip:-strip, strip:-strip] = False
        inner[at_side & ~_opened(inner, _STRIP_CELLS)] = False
        parts = np.zeros(self._count.shape, dtype=np.bool_)
        parts[self._inner] = inner
        return self._pieces(parts, smallest)

    @cached_property
    def _judged(self) -> _Judged:
        """The cells that stand out of the floor by more than its noise."""
        seen = self._count > 0
        if not seen.any():
            return _Judged(seen, np.inf, self._best.floor)
        height = self._sum / np.maximum(self._count, 1.0)
        above, floor = _over_floor(height, seen)
        higher = float(np.median((height - above)[floor])) if floor.any() else 0.0
        if higher > self._tolerance:  # something lies on all of it
            above, higher = above + higher, 0.0
        lowest = max(_LOWEST, _SIGMAS * _scatter(above[floor]))
        occupied = seen & (above > lowest)
        low = seen & ~occupied
        inside = cv2.blur(low.astype(np.float32), (_WINDOW, _WINDOW))
        mean = cv2.blur(np.where(low, above, 0.0), (_WINDOW, _WINDOW)) / np.maximum(inside, 1e-6)
        full = low & (inside > 0.5)
        wide = max(_LOWEST_WIDE, _SIGMAS * _scatter(mean[floor & full]))
        occupied |= full & (mean > wide)
        return _Judged(occupied, lowest, self._best.floor + higher)

    def _pieces(self, mask: Mask, smallest: float) -> list[Segment]:
        count, _, stats, centres = cv2.connectedComponentsWithStats(
            mask.astype(np.uint8), connectivity=4
        )
        return [
            Segment(
                centre=self._world(centres[i][::-1]), area=area
            )  # OpenCV's x is the second axis
            for i in range(1, count)
            if (area := float(stats[i, cv2.CC_STAT_AREA]) * self._cell**2) >= smallest
        ]

    def _world(self, cells: Array) -> Array:
        """(..., 3) of cells (2, ...) on the floor, in odometry [m]."""
        x, y = ((cells.T + 0.5) * self._cell + self._corner).T
        local = np.stack([x, y, np.full_like(x, -self._size[2] / 2.0)], axis=-1)
        return np.asarray(local @ self.oTr.rotation.T + self.oTr.translation)


def _opened(mask: Mask, side: int, shape: int = cv2.MORPH_RECT) -> Mask:
    """Without what no square of this side [cells] fits into, or no disc."""
    one = cv2.getStructuringElement(shape, (side, side))
    opened: Mask = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, one) > 0
    return opened


def _closed(mask: Mask) -> Mask:
    """With the gaps of one cell or two."""
    square = np.ones((3, 3), np.uint8)
    closed: Mask = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_CLOSE, square) > 0
    return closed


def _over_floor(height: Array, seen: Mask) -> tuple[Array, Mask]:
    """Heights (X, Y) over the plane of the floor [m], and which cells show it.

    A plane is fitted to what is near the height 0, then to the lower half of that, so that it finds
    the floor though most of it be covered; then to all that is near the plane. If hardly any cell
    shows a floor, it is at 0.
    """
    x, y = np.indices(height.shape, dtype=float)
    terms = np.stack([np.ones_like(x), x, y], axis=-1)
    near = seen & (np.abs(height) < _NEAR_FLOOR)
    floor, above = near, height
    for is_lower_half in _ROUNDS:
        if floor.sum() < _LEAST_CELLS:
            return height, near
        plane, *_ = np.linalg.lstsq(terms[floor], height[floor], rcond=None)
        above = height - terms @ plane
        if is_lower_half:
            floor = floor & (above <= np.median(above[floor]))
        else:
            floor = near & (np.abs(above) < max(_LOWEST_WIDE, 3.0 * _scatter(above[floor])))
    return above, floor


def _scatter(above: Array) -> float:
    """Standard deviation of heights over a plane, from those below it [m]."""
    below = above[above <= 0.0]
    return float(np.sqrt(np.mean(below**2))) if len(below) else 0.0
