"""Conditions on the newest picture, or scan: what stands in a region, or near the base."""

from math import ceil, radians
from typing import Annotated, ClassVar

import numpy as np
from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.leaf import Condition
from behaviours.core.parameter_types import Area, Bounds, Count, Distance, Region
from behaviours.views.survey import glance, unseen
from config import counted
from controller import Array
from hw import DepthFrame

_SCAN_AGE = 0.3  # of a scan that tells what is near [s]


class ObstacleWithin(Condition):
    """Succeeds if the laser sees something near the base, at the height of its beam.

    Everything counts, furniture too. Fails if it sees that nothing is near: where no beam goes, as
    behind most bases, that is not known, nor from a scan that is older than 0.3 s or of which no
    beam comes back. Of one beam alone that does not, it sees open space, glass or something black.

    Args:
        distance_m: from the outline of the base [m].
        sector_deg: what is asked about, as seen from the laser: so much, half of it to either side
            of straight ahead [deg].
    """

    key: ClassVar[str] = "obstacle_within"
    near_furniture: ClassVar[str] = "distance_m"

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        distance_m: Distance,
        sector_deg: Annotated[float, Bounds(least=1, most=360)] = 360.0,
    ) -> None:
        super().__init__(name, context)
        self._distance, self._half = distance_m, radians(sector_deg) / 2.0
        laser, self._blind = context.robot.description.laser, "the robot has no laser"
        if laser is not None:
            beams, gap = _bearings(laser.beams), float(np.diff(laser.angles).max(initial=0.0))
            asked = np.linspace(-self._half, self._half, 361)
            off = np.abs(np.remainder(asked[:, None] - beams + np.pi, 2.0 * np.pi) - np.pi)
            covered = sector_deg * float((off.min(axis=1) <= gap / 2.0 + 1e-6).mean())
            sees = f"the laser sees {covered:.0f} of the {sector_deg:g}° asked about"
            self._blind = "" if covered == sector_deg else f"{sees}; `sector_deg` asks about less"

    def update(self) -> Status:
        """One tick."""
        robot = self.context.robot
        laser, scan = robot.description.laser, robot.laser.latest(_SCAN_AGE)
        if laser is None or scan is None:
            return self.unknown(self._blind if laser is None else "no scan tells what is near")
        seen = scan.points[np.isfinite(scan.ranges)]
        if not len(seen):
            return self.unknown("no beam of the laser comes back")
        seen = seen[np.abs(_bearings(seen - laser.bTs.translation)) <= self._half]
        half = np.array(robot.description.base.size[:2]) / 2.0
        outside = np.maximum(np.abs(seen[:, :2]) - half, 0.0)
        nearest = float(np.linalg.norm(outside, axis=1).min(initial=np.inf))
        text = f"the nearest that the laser sees is {nearest:.2f} m away"
        if nearest < self._distance:
            return self.success(text)
        return self.unknown(self._blind) if self._blind else self.failure(text)


def _bearings(vectors: Array) -> Array:
    """(n,) directions of vectors (n, 3), from straight ahead to the left [rad]."""
    return np.asarray(np.arctan2(vectors[:, 1], vectors[:, 0]))


class _Glance(Condition):
    """What the newest picture shows of a region; a frame is judged once."""

    def __init__(self, name: str, context: Context, region: Region, smallest_cm2: float) -> None:
        super().__init__(name, context)
        self._region = region
        self._smallest = 1e-4 * smallest_cm2
        self._judged: DepthFrame | None = None

    def _look(self) -> str:
        """Count what stands there; returns why there may be more, if so."""
        vision, stamp = self.context.vision, self.context.state.stamp
        frame, self._count = vision.picture(stamp), 0
        if frame is None:
            return vision.blindness(stamp)
        if frame is not self._judged:
            with vision.timed():
                seen = glance(self.context, self._region, frame)
                self._lowest = seen.lowest
                self._seen = (
                    len(seen.segments(self._smallest)),
                    (
                        unseen(seen, self._region, self._smallest)
                        if seen.seen > 0.0
                        else f"{self._region.name} is out of view"
                    ),
                )
            self._judged = frame
        self._count = self._seen[0]
        return self._seen[1]

    @property
    def _text(self) -> str:
        what = counted(self._count, "object")
        if not self._count:
            what = f"nothing over {ceil(1000 * self._lowest)} mm"
        return f"{what} seen in {self._region.name}"


class ObjectVisible(_Glance):
    """Succeeds if the newest picture of the camera shows something that stands in a region.

    Without them, that is not known unless the picture shows the whole floor. Objects that touch
    each other count as one.

    Args:
        within: region of the task file; its floor is what objects stand on.
        least: smallest number of objects.
        smallest_cm2: less than this, seen from above, counts as nothing [cm^2].
    """

    key: ClassVar[str] = "object_visible"
    surfaces: ClassVar[tuple[str, ...]] = ("within",)

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        within: Region,
        least: Count = 1,
        smallest_cm2: Area = 1.0,
    ) -> None:
        super().__init__(name, context, within, smallest_cm2)
        self._least = least

    def update(self) -> Status:
        """One tick."""
        if (hidden := self._look()) and self._count < self._least:
            return self.unknown(hidden)
        return (self.success if self._count >= self._least else self.failure)(self._text)


class RegionFree(_Glance):
    """Succeeds if the newest picture of the camera shows a region, and nothing stands in it.

    That is not known without a picture, or if it does not show the whole floor; `region_empty`
    moves the camera until it does. It names the height below which an object may be overlooked.

    Args:
        region: of the task file; its floor is what objects stand on.
        smallest_cm2: less than this, seen from above, counts as nothing [cm^2].
    """

    key: ClassVar[str] = "region_free"
    surfaces: ClassVar[tuple[str, ...]] = ("region",)

    def __init__(
        self, name: str, context: Context, *, region: Region, smallest_cm2: Area = 1.0
    ) -> None:
        super().__init__(name, context, region, smallest_cm2)

    def update(self) -> Status:
        """One tick."""
        if (hidden := self._look()) and not self._count:
            return self.unknown(hidden)
        return (self.failure if self._count else self.success)(self._text)
