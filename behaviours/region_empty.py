"""Behaviour `region_empty`: test that no object stands in a region."""

from functools import partial
from math import ceil
from typing import ClassVar

from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.leaf import Leaf
from behaviours.core.parameter_types import Area, Region
from behaviours.views.survey import Survey, view_directions
from behaviours.views.viewpoint import GLANCE_PATIENCE


class RegionEmpty(Leaf):
    """Look into a region, and succeed if nothing stands in it.

    It looks from where the hand is, at rest. Where the pictures do not show the whole floor, it
    goes over the region and looks straight down. It names the height below which an object, or a
    flat cover of the whole floor, may be overlooked. Fails when something is left, a part of the
    floor stays hidden, the camera gives no usable picture, or the robot has a fault.

    Args:
        region: of the task file; its floor is what objects stand on.
        smallest_cm2: less than this, seen from above, counts as nothing [cm^2].
    """

    key: ClassVar[str] = "region_empty"
    surfaces: ClassVar[tuple[str, ...]] = ("region",)

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        region: Region,
        smallest_cm2: Area = 1.0,
    ) -> None:
        super().__init__(name, context)
        self._region, self._smallest = region, 1e-4 * smallest_cm2
        self._look = partial(
            Survey,
            self,
            region,
            patience=GLANCE_PATIENCE,
            smallest=self._smallest,
            directions=view_directions(context, region),
            from_here=True,
        )

    def initialise(self) -> None:
        """Start to look."""
        self._survey = self._look()

    def update(self) -> Status:
        """One tick."""
        status = self._survey.tick()
        if status is not Status.SUCCESS:
            return status
        seen = self._survey.map
        self.context.log.note_stock(self._region, seen.pieces)
        if standing := seen.segments(self._smallest):
            area = 1e4 * sum(one.area for one in standing)
            return self.failure(f"{area:.0f} cm² of {self._region.name} occupied")
        if not (unseen := self._survey.unseen):
            lowest, cover = ceil(1000 * seen.lowest), ceil(1000 * seen.cover)
            flat = f", no flat cover over {cover} mm" if cover > lowest else ""
            share = 100 * seen.seen
            return self.success(f"nothing over {lowest} mm{flat}, on the {share:.0f} % seen")
        if self._survey.another_view():
            return self.running(f"{unseen}; looking from another view")
        return self.failure(unseen)
