"""Behaviour `detect`: tell apart the objects in a region."""

from dataclasses import replace
from typing import ClassVar

from py_trees.common import Status

from behaviours.core.arguments import validate_choice
from behaviours.core.context import Context
from behaviours.core.leaf import Leaf
from behaviours.core.parameter_types import Key, LowerBound, Millimetres, Region
from behaviours.views.objects import Choice, Choose, ObjectDetection
from behaviours.views.viewpoint import GLANCE_PATIENCE
from perception import ColourName, DetectedObjects


class Detect(Leaf):
    """Look at a region from where the hand is, at rest, and tell apart what stands in it.

    What it finds can be the goal of `navigate`, `look_at` and `grasp`, one after the other below
    `for_each`. Succeeds with any number of objects, but says that there are none, or how many there
    are, only where the pictures show the region; where objects hide a part of it that could hold
    another one as wide as asked for, there are at least as many. Fails when they do not, when
    something is too low to be told apart, when the camera gives no usable picture, or sees no
    colours and is asked for one.

    Args:
        region: of the task file; its floor is what objects stand on.
        list: key for what stands there: place, size, width and colour of each object.
        count: key for the number of objects.
        choose: which comes first: the largest covers most, seen from above, and the nearest is near
            to the base; `best` goes from the left of the image to the right.
        kind: only objects of this kind: `box`, `can`, `ball`, `roll`, or what a package recognises.
        colour: only objects of this colour.
        min_width_mm: only those whose shorter edge, seen from above, is at least this [mm].
        max_width_mm: only those whose shorter edge is at most this [mm].
    """

    key: ClassVar[str] = "detect"
    counts: ClassVar[str] = "count"
    moves: ClassVar[bool] = False
    surfaces: ClassVar[tuple[str, ...]] = ("region",)
    validate = staticmethod(validate_choice)

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        region: Region,
        list: Key[DetectedObjects] | None = None,
        count: Key[int] | None = None,
        choose: Choose = "best",
        kind: str | None = None,
        colour: ColourName | None = None,
        min_width_mm: Millimetres | None = None,
        max_width_mm: Millimetres | None = None,
    ) -> None:
        super().__init__(name, context)
        self._list, self._count = list, count
        self._choice = Choice.of(choose, kind, colour, min_width_mm, max_width_mm)
        self._detection = ObjectDetection(context, region, self._choice)
        context.direction(region)  # in which what it finds is come to

    def initialise(self) -> None:
        """Start to look."""
        self._begun = self.context.clock.now()
        self._detection.begin(self.context.state.stamp)

    def update(self) -> Status:
        """One tick; standing still, as no goal is left."""
        vision, state = self.context.vision, self.context.state
        objects = self._detection.update()
        if objects is None:
            if self.context.clock.now() - self._begun > GLANCE_PATIENCE:
                return self.failure(vision.blindness(state.stamp) or "no camera frame")
            return self.running("looking")
        if isinstance(objects, str):
            return self.failure(objects)
        drift, mTo = self.context.drift(), self.context.localisation.mTo
        fitting = self._choice.fitting(objects, state.oTb.translation)
        found = DetectedObjects(replace(one, drift=drift, mTo=mTo) for one in fitting)
        if (self._count is not None or not found) and (unseen := self._detection.unseen(objects)):
            return self.failure(unseen)
        if self._list is not None:
            self._list.write(found)
        if self._count is not None:
            count = len(found)
            self._count.write(LowerBound(count) if self._detection.hides else count)
        return self.success(f"{len(found)} of {len(objects)}: {found}")
