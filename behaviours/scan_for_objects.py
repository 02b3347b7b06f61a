"""Look at a region from as many places as it takes, and count what stands in it."""

from __future__ import annotations

from math import ceil
from typing import ClassVar

import numpy as np
from py_trees.common import Status

from behaviours.aiming import camera_pose, hand_for, straight_down
from behaviours.approach import Approach
from behaviours.context import Context
from behaviours.key import Key
from behaviours.leaf import Leaf
from behaviours.occupancy import Occupancy
from behaviours.poses import Region
from behaviours.ranges import Area, Count, Distance, Seconds
from controller import PoseGoal


class ScanForObjects(Leaf):
    """Look straight down at a region, from several views if it is large, and count the objects.

    Objects that touch each other count as one. Succeeds with any count, none included. Fails when
    there is no camera frame, a part of the region stays hidden, a view is not reached, or the robot
    has a fault.

    Args:
        region: of the task file; its floor is what objects stand on.
        count: key for the number of objects.
        height_m: of the camera over the floor [m].
        frames: pictures to take from each view.
        smallest_cm2: less than this, seen from above, counts as nothing [cm^2].
        timeout_s: time to reach a view [s].
    """

    key: ClassVar[str] = "scan_for_objects"
    surfaces: ClassVar[tuple[str, ...]] = ("region",)

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        region: Region,
        count: Key[int],
        height_m: Distance = 0.45,
        frames: Count = 3,
        smallest_cm2: Area = 1.0,
        timeout_s: Seconds = 30.0,
    ) -> None:
        super().__init__(name, context)
        self._region = region
        self._count = count
        self._height = height_m
        self._frames = frames
        self._smallest = 1e-4 * smallest_cm2
        self._timeout = timeout_s
        self._views = views(region, self.settings.view.width_per_height * height_m)

    def initialise(self) -> None:
        """Start anew with the first view."""
        self._wTc = camera_pose(self.context)
        self._occupancy = Occupancy(self._region, self.settings.counting)
        self._view = 0
        self._taken = 0
        self._approach: Approach | None = None
        self._there = False

    def update(self) -> Status:
        """One tick."""
        if not self._there:
            status = self._go()
            if status is not Status.SUCCESS:
                return status
            self._there, self._taken, self._waiting_since = True, 0, self.context.clock.now()
        return self._take_pictures()

    def _go(self) -> Status:
        """One tick of the way to the view whose turn it is."""
        if self._approach is None:
            wTc = straight_down(self._views[self._view], self._height, like=self._wTc)
            goal = PoseGoal(wTe=hand_for(self.context, wTc))
            target = f"view {self._view + 1} of {len(self._views)} of {self._region.name}"
            self._approach = Approach(self, goal, target, self._timeout)
        return self._approach.tick()

    def _take_pictures(self) -> Status:
        """One tick of standing in a view; no goal is left, so the hand comes to rest."""
        if fault := self.fault():
            return self.failure(fault)
        vision, now = self.context.vision, self.context.clock.now()
        frame = vision.new_frame()
        if frame is not None:
            with vision.timed():
                self._occupancy.add(frame)
            self._taken, self._waiting_since = self._taken + 1, now
        elif now - self._waiting_since > self.settings.view.patience:
            return self.failure("no camera frame")
        seen = f"view {self._view + 1} of {len(self._views)}"
        if self._taken < self._frames:
            return self.running(f"{seen}, {self._taken} pictures")
        if self._view + 1 < len(self._views):
            self._view += 1
            self._approach, self._there = None, False
            return self.running(f"{seen} taken")
        return self._conclude()

    def _conclude(self) -> Status:
        if self._occupancy.seen < self.settings.view.least_seen:
            share = 100.0 * self._occupancy.seen
            return self.failure(f"only {share:.0f} % of {self._region.name} could be seen")
        count = len(self._occupancy.segments(self._smallest))
        self._count.write(count)
        return self.success(f"{count} objects in {self._region.name}")


def views(region: Region, side: float) -> list[np.ndarray]:
    """Points (3,) on the floor of a region, in the world, to look at one after the other.

    Args:
        region: squares around them cover it.
        side: of a square [m].
    """
    columns, rows = (max(1, ceil(edge / side - 1e-9)) for edge in region.size[:2])
    x, y = (
        (np.arange(n) + 0.5) * edge / n - edge / 2.0
        for n, edge in ((columns, region.size[0]), (rows, region.size[1]))
    )
    down = -region.size[2] / 2.0
    return [
        region.wTr.act(np.array([x[column], y[row], down]))
        for row in range(rows)
        for column in (range(columns) if row % 2 == 0 else reversed(range(columns)))
    ]
