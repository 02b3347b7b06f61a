"""Whether anything is left in a region, judged by the camera alone."""

from __future__ import annotations

from math import isnan
from typing import ClassVar

from py_trees.common import Status

from behaviours.context import Context
from behaviours.leaf import Leaf
from behaviours.poses import Region
from behaviours.ranges import Area, Count, Seconds


class RegionEmpty(Leaf):
    """Look into a region from where the hand is, at rest, and succeed if nothing stands in it.

    Fails when something is left, and when the camera gives no usable picture.

    Args:
        region: of the task file; its floor is what objects stand on.
        smallest_cm2: less than this, seen from above, counts as nothing [cm^2].
        frames: how many pictures must agree.
        patience_s: give up without a picture after this [s].
    """

    key: ClassVar[str] = "region_empty"
    moves: ClassVar[bool] = False
    surfaces: ClassVar[tuple[str, ...]] = ("region",)

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        region: Region,
        smallest_cm2: Area = 1.0,
        frames: Count = 3,
        patience_s: Seconds = 1.0,
    ) -> None:
        super().__init__(name, context)
        self._region = region
        self._smallest = 1e-4 * smallest_cm2
        self._frames = frames
        self._patience = patience_s

    def initialise(self) -> None:
        """Start to look."""
        self._begun = self.context.clock.now()
        self._empty = 0

    def update(self) -> Status:
        """One tick; standing still, as no goal is left."""
        seen = self.context.vision.detect(self._region)
        if seen is None or isnan(seen.occupied_area):
            if self.context.clock.now() - self._begun > self._patience:
                return self.failure(seen.reason if seen else "no camera frame")
            return self.running("looking")
        if seen.occupied_area > self._smallest:
            return self.failure(f"{1e4 * seen.occupied_area:.0f} cm² occupied")
        self._empty += 1
        if self._empty < self._frames:
            return self.running(f"seen empty {self._empty} times")
        return self.success("nothing left to grasp")
