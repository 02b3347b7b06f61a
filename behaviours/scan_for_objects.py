"""Behaviour `scan_for_objects`: count the objects in a region."""

from functools import partial
from typing import ClassVar

from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.leaf import Leaf
from behaviours.core.parameter_types import (
    Area,
    Distance,
    Key,
    LowerBound,
    Region,
    Timeout,
)
from behaviours.views.survey import Survey, unseen, view_directions
from config import counted


class ScanForObjects(Leaf):
    """Look straight down at a region, from several views if it is large, and count the objects.

    Over what objects hide from all of these it looks again. What stays hidden then may be others:
    the count is at least so many, and whether it is exactly so many is not known. Objects that
    touch each other count as one. Succeeds with any count, none included. Fails when there is no
    camera frame, more than a tenth of the region stays hidden, a view is not reached, or the robot
    has a fault.

    Args:
        region: of the task file; its floor is what objects stand on.
        count: key for the number of objects.
        height_m: of the camera over the floor [m].
        smallest_cm2: less than this, seen from above, counts as nothing [cm^2].
        timeout_s: time to reach a view [s].
    """

    key: ClassVar[str] = "scan_for_objects"
    counts: ClassVar[str] = "count"
    surfaces: ClassVar[tuple[str, ...]] = ("region",)

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        region: Region,
        count: Key[int],
        height_m: Distance = 0.45,
        smallest_cm2: Area = 1.0,
        timeout_s: Timeout = 30.0,
    ) -> None:
        super().__init__(name, context)
        self._region, self._count, self._smallest = region, count, 1e-4 * smallest_cm2
        self._look = partial(
            Survey,
            self,
            region,
            smallest=self._smallest,
            directions=view_directions(context, region, height_m),
            from_here=False,
            height=height_m,
            timeout=timeout_s,
        )

    def initialise(self) -> None:
        """Start anew with the first view."""
        self._survey = self._look()

    def update(self) -> Status:
        """One tick."""
        status = self._survey.tick()
        if status is not Status.SUCCESS:
            return status
        if self._survey.another_view():
            return self.running(self.feedback_message)
        if missing := self._survey.unseen:
            return self.failure(missing)
        seen = self._survey.map
        count = len(seen.segments(self._smallest))
        if unseen(seen, self._region, self._smallest, whole=True):
            count = LowerBound(seen.fewest(self._smallest))
        self._count.write(count)
        self.context.log.note_stock(self._region, seen.pieces)
        share = f"on the {100 * seen.seen:.0f} % seen"
        return self.success(f"{counted(count, 'object')} in {self._region.name}, {share}")
