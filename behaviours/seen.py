"""Conditions on the newest picture, or scan: what stands in a region, or near the base."""

from typing import ClassVar

import numpy as np
from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.leaf import Condition
from behaviours.core.parameter_types import Area, Count, Distance, Region
from behaviours.views.survey import LEAST_SEEN, glance
from config import counted
from hw import DepthFrame

_SCAN_AGE = 0.3  # of a scan that tells what is near [s]


class ObstacleWithin(Condition):
    """Succeeds if the laser sees something near the base, at the height of its beam.

    Everything counts, furniture too. What is not seen is not free: without a scan of the last
    0.3 s it succeeds as well.

    Args:
        distance_m: from the outline of the base [m].
    """

    key: ClassVar[str] = "obstacle_within"

    def __init__(self, name: str, context: Context, *, distance_m: Distance) -> None:
        super().__init__(name, context)
        self._distance = distance_m

    def update(self) -> Status:
        """One tick."""
        robot = self.context.robot
        if (scan := robot.laser.latest(_SCAN_AGE)) is None:
            return self.success("no scan tells what is near")
        half = np.array(robot.description.base.size[:2]) / 2.0
        seen = scan.points[np.isfinite(scan.ranges), :2]
        outside = np.maximum(np.abs(seen) - half, 0.0)
        nearest = float(np.linalg.norm(outside, axis=1).min(initial=np.inf))
        text = f"the nearest that the laser sees is {nearest:.2f} m away"
        return self.success(text) if nearest < self._distance else self.failure(text)


class _Glance(Condition):
    """What the newest picture shows of a region; a frame is judged once."""

    def __init__(self, name: str, context: Context, region: Region, smallest_cm2: float) -> None:
        super().__init__(name, context)
        self._region = region
        self._smallest = 1e-4 * smallest_cm2
        self._judged: DepthFrame | None = None

    def _look(self) -> str:
        """Count what stands there; returns why that cannot be told, if so."""
        vision, stamp = self.context.vision, self.context.state.stamp
        vision.new_frame()
        if vision.frame is None or vision.is_blind(stamp):
            return vision.blindness(stamp) or "no camera frame"
        if vision.frame is not self._judged:
            self._judged = vision.frame
            with vision.timed():
                seen = glance(self.context, self._region, vision.frame)
                self._count, self._share = len(seen.segments(self._smallest)), seen.seen
        return "" if self._share > 0.0 else f"{self._region.name} is out of view"

    @property
    def _text(self) -> str:
        text = f"{counted(self._count, 'object')} seen in {self._region.name}"
        if self._share < LEAST_SEEN:
            text += f", {100 * (1 - self._share):.0f} % of which is not seen"
        return text


class ObjectVisible(_Glance):
    """Succeeds if the newest picture of the camera shows something that stands in a region.

    Fails too when there is no picture, or the region is not in it. Objects that touch each other
    count as one.

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
        if blind := self._look():
            return self.failure(blind)
        return (self.success if self._count >= self._least else self.failure)(self._text)


class RegionFree(_Glance):
    """Succeeds if the newest picture of the camera shows a region, and nothing stands in it.

    Fails too when there is no picture, or it does not show the whole floor; `region_empty` moves
    the camera until it does.

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
        if blind := self._look():
            return self.failure(blind)
        is_free = not self._count and self._share >= LEAST_SEEN
        return (self.success if is_free else self.failure)(self._text)
