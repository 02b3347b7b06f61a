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


class ObjectVisible(Condition):
    """Succeeds if the newest picture of the camera shows something that stands in a region.

    Without so many, that is not known unless the picture shows the whole floor, and no object hides
    a part that could hold one; `region_empty` moves the camera until it does. Objects that touch
    each other count as one. It names the height below which an object may be overlooked.

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
        super().__init__(name, context)
        self._region, self._least, self._smallest = within, least, 1e-4 * smallest_cm2
        self._judged: DepthFrame | None = None

    def update(self) -> Status:
        """One tick."""
        vision, stamp = self.context.vision, self.context.state.stamp
        frame = vision.picture(stamp)
        if frame is None:
            return self.unknown(vision.blindness(stamp))
        if frame is not self._judged:
            with vision.timed():
                self._judge(frame)
            self._judged = frame
        if self._hidden and self._count < self._least:
            return self.unknown(self._hidden)
        what = counted(self._count, "object")
        if not self._count:
            what = f"nothing over {ceil(1000 * self._lowest)} mm"
        answer = self.success if self._count >= self._least else self.failure
        return answer(f"{what} seen in {self._region.name}")

    def _judge(self, frame: DepthFrame) -> None:
        """Count what stands there, and say why there may be more, if so."""
        seen = glance(self.context, self._region, frame)
        self._count = len(seen.segments(self._smallest))
        self._hidden = f"{self._region.name} is out of view"
        if seen.seen > 0.0:
            self._hidden = unseen(seen, self._region, self._smallest, whole=True)
        self._lowest = seen.lowest
