"""Conditions on the newest picture, or scan: what stands in a region, or near the base."""

from math import ceil
from typing import Annotated, ClassVar

import numpy as np
from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.leaf import Condition
from behaviours.core.parameter_types import Area, Bounds, Count, Distance, Region
from behaviours.views.survey import glance, unseen
from config import counted
from hw import DepthFrame

_GAP = 5.0  # between two beams, where nothing that is near hides: a leg at a metre [deg]


class ObstacleWithin(Condition):
    """Succeeds if the laser sees something near the base, at the height of its beam.

    Everything counts, furniture too. Fails if it sees that nothing is near. That is not known from
    a scan that is older than 0.3 s or repeats an older one, and where over more than 5° no beam
    tells anything: behind most bases, under dirt, and in open space of a laser that leaves out what
    has no echo, as that of an Omron base does.

    Args:
        distance_m: from the outline of the base [m].
        sector_deg: what is asked about, as seen from the laser: so much, half of it to either side
            of straight ahead [deg].
    """

    key: ClassVar[str] = "obstacle_within"

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        distance_m: Distance,
        sector_deg: Annotated[float, Bounds(least=1, most=360)] = 360.0,
    ) -> None:
        super().__init__(name, context)
        self._distance, self._sector = distance_m, sector_deg

    def update(self) -> Status:
        """One tick."""
        robot = self.context.robot
        laser, scan = robot.description.laser, self.context.scan()
        if laser is None or scan is None:
            mistake = self.context.around.scans.mistake or "no scan tells what is near"
            return self.unknown("the robot has no laser" if laser is None else mistake)
        x, y, _ = (scan.points - laser.bTs.translation).T
        bearings, end = np.degrees(np.arctan2(y, x)), self._sector / 2.0
        told = (scan.ranges > 0.0) & (np.abs(bearings) <= end)
        half = np.array(robot.description.base.size[:2]) / 2.0
        seen = scan.points[told & np.isfinite(scan.ranges), :2]
        outside = np.maximum(np.abs(seen) - half, 0.0)
        nearest = float(np.linalg.norm(outside, axis=1).min(initial=np.inf))
        what = f"{nearest:.2f} m away" if len(seen) else "out of its reach"
        text = f"the nearest that the laser sees is {what}"
        if nearest < self._distance:
            return self.success(text)
        gaps = np.diff(np.sort([-end, *bearings[told], end]))
        if blind := float(gaps[gaps > _GAP].sum()):
            sees = f"the laser sees {self._sector - blind:.0f} of the {self._sector:g}° asked about"
            return self.unknown(f"{sees}; `sector_deg` asks about less")
        return self.failure(text)


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
                        unseen(seen, self._region, self._smallest, whole=True)
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

    Without so many, that is not known unless the picture shows the whole floor, and no object hides
    a part that could hold one. Objects that touch each other count as one.

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
