"""A look into a region: pictures from where the camera is and from more views, as one map."""

from __future__ import annotations

from math import ceil

import numpy as np
from py_trees.common import Status

from behaviours.aiming import camera_pose, hand_for, straight_down
from behaviours.approach import Approach
from behaviours.leaf import Leaf
from behaviours.poses import Region
from behaviours.settings import OccupancySettings, ViewSettings
from controller import PoseGoal
from hw import DepthFrame
from perception import RegionMap


class Survey:
    """Takes pictures of a region from one view after the other; at rest, but for the ways between.

    Args:
        leaf: whose survey it is.
        region: whose floor is looked at.
        frames: pictures from each view.
        smallest: a part that was not seen and covers less than this does not count [m^2].
        from_here: begin with a view from where the hand is.
        height: of the camera over the floor, in the views that it goes to [m].
        timeout: to reach a view [s].
        patience: without a picture [s].
    """

    def __init__(
        self,
        leaf: Leaf,
        region: Region,
        *,
        frames: int,
        smallest: float,
        from_here: bool,
        height: float = 0.45,
        timeout: float = 30.0,
        patience: float = 2.0,
    ) -> None:
        self._leaf, self._region = leaf, region
        self._height, self._frames, self._timeout = height, frames, timeout
        self._smallest, self._patience = smallest, patience
        self._like = camera_pose(leaf.context)
        self._views = views(region, leaf.settings.view.width_per_height * height)
        self._next = 0
        self._approach: Approach | None = None
        self._there = from_here
        if not from_here:
            self.another_view()
        self._begin()

    def _begin(self) -> None:
        """Forget what was seen."""
        self.map = map_of(self._region, self._leaf.settings.counting)
        self._since = self._leaf.context.state.stamp
        self._arrive()

    def _arrive(self) -> None:
        self._taken, self._waiting_since = 0, self._leaf.context.clock.now()

    @property
    def unseen(self) -> str:
        """What of the region was not seen, in words; empty if all of it that matters was."""
        return unseen(self.map, self._region, self._smallest, self._leaf.settings.view)

    def tick(self) -> Status:
        """Go on; SUCCESS when the pictures of a view are taken, FAILURE if that cannot be."""
        leaf = self._leaf
        if fault := leaf.fault():
            return leaf.failure(fault)
        if leaf.context.relocalised:
            self._begin()  # what was seen is not where it was
        if not self._there:
            status = self._go()
            if status is not Status.SUCCESS:
                return status
            self._there = True
            self._arrive()
        return self._take_pictures()

    def another_view(self) -> bool:
        """Set out for the next view; whether there is one."""
        if self._next == len(self._views):
            return False
        self._next += 1
        self._approach, self._there = None, False
        return True

    def _go(self) -> Status:
        """One tick of the way to the view whose turn it is."""
        if self._approach is None:
            wTc = straight_down(self._views[self._next - 1], self._height, like=self._like)
            target = f"view {self._next} of {len(self._views)} of {self._region.name}"
            goal = PoseGoal(wTe=hand_for(self._leaf.context, wTc))
            self._approach = Approach(self._leaf, goal, target, self._timeout)
        return self._approach.tick()

    def _take_pictures(self) -> Status:
        """One tick of standing in a view; no goal is left, so the hand comes to rest."""
        leaf, context = self._leaf, self._leaf.context
        vision, now = context.vision, context.clock.now()
        frame = vision.new_frame()
        blindness = vision.blindness(context.state.stamp)
        if frame is not None and frame.stamp >= self._since and not blindness:
            with vision.timed():
                self.map.add(frame)
            self._taken, self._waiting_since = self._taken + 1, now
        elif now - self._waiting_since > self._patience:
            return leaf.failure(blindness or "no camera frame")
        if self._taken < self._frames:
            return leaf.running(f"looking at {self._region.name}, {self._taken} pictures")
        return leaf.success(f"looked at {self._region.name}")


def map_of(region: Region, settings: OccupancySettings, *frames: DepthFrame) -> RegionMap:
    """A map of a region.

    Args:
        region: of the task file.
        settings: how finely it is looked at.
        frames: that it has taken in.
    """
    seen = RegionMap(region.wTr, region.size, settings.cell, settings.stride)
    for frame in frames:
        seen.add(frame)
    return seen


def unseen(seen: RegionMap, region: Region, smallest: float, settings: ViewSettings) -> str:
    """What a map does not show of a region, in words; empty if that cannot hide an object.

    What stands there hides a part of the floor; where nothing stands, nothing may be hidden.

    Args:
        seen: the map.
        region: that it is of.
        smallest: a part that covers less than this does not count [m^2].
        settings: how much has to be seen, and how well.
    """
    if seen.segments(smallest) and seen.seen >= settings.least_seen_around_objects:
        return ""
    parts = seen.hidden(smallest)
    if seen.seen < settings.least_seen or parts:
        text = f"{100.0 * (1.0 - seen.seen):.0f} % of {region.name} not seen"
        if not parts:
            return text
        part = max(parts, key=lambda one: one.area)
        x, y, _ = part.centre
        return f"{text}, most of it ({1e4 * part.area:.0f} cm²) around {x:.2f}, {y:.2f}"
    if seen.lowest > settings.most_overlooked:
        return f"what is lower than {1000 * seen.lowest:.0f} mm is not seen from so far"
    return ""


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
