"""What a grasp is looked for on, which is chosen once and then followed."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from behaviours.choice import Choice, Chosen, neighbours
from behaviours.context import Context
from behaviours.objects_in_sight import ObjectsInSight, look_once
from behaviours.poses import Region
from perception import DetectedObject, GraspEstimate

Array = npt.NDArray[np.float64]


class Target:
    """What a grasp is looked for on: all that stands in a region, or what is chosen there.

    Args:
        context: of the tree.
        within: a region, or an object that was detected.
        choice: what is meant of a region.
        neighbour: take what stands beside that instead.
    """

    def __init__(
        self,
        context: Context,
        within: Region | DetectedObject,
        choice: Choice,
        *,
        neighbour: bool = False,
    ) -> None:
        self._context, self._within, self._choice = context, within, choice
        self._neighbour = neighbour
        self._sight = None
        if isinstance(within, Region) and not choice.is_free:
            self._sight = ObjectsInSight(context, within, choice)
        self.begin()

    def begin(self, since: float = -np.inf) -> None:
        """Choose anew, by frames from session time `since` [s] on."""
        self.reason = ""
        """Why nothing is chosen; empty if it is, or nobody has looked yet."""
        self._chosen: Chosen | None = None
        if self._sight is not None:
            self._sight.begin(since)
        if isinstance(self._within, DetectedObject):
            self._chosen = Chosen(objects=(self._within,))

    def track(self, now: float) -> GraspEstimate | None:
        """The grasp that is followed on it, as `Vision.track` says; None if nothing is chosen.

        Args:
            now: session time [s].
        """
        vision, within = self._context.vision, self._within
        if isinstance(within, Region) and self._choice.is_free:
            return vision.track(within, now)
        if self._chosen is None and self._sight is not None:
            self._choose(self._sight)
        if self._chosen is None:
            return None
        return vision.track(self._chosen, now)

    def middle(self) -> Array | None:
        """(3,) of what is meant, as the newest frame shows it, in the world [m]; None if none is.

        Of several it is the largest.
        """
        frame, base = self._context.vision.frame, self._context.state.wTb.translation
        if self._chosen is not None:
            return self._chosen.objects[0].position
        if frame is None or not isinstance(self._within, Region):
            return None
        with self._context.vision.timed():
            objects = look_once(frame, self._within, self._choice)
        if isinstance(objects, str):
            return None
        fitting = self._choice.fitting(objects, base)
        return max(fitting, key=lambda one: one.area).position if fitting else None

    def _choose(self, sight: ObjectsInSight) -> None:
        objects = sight.look()
        if objects is None:
            return
        if isinstance(objects, str):
            self.reason = objects
            return
        fitting = self._choice.fitting(objects, self._context.state.wTb.translation)
        if not fitting:
            self.reason = f"{self._choice} is not among the {len(objects)} objects in sight"
            return
        is_one = self._choice.choose != "best"
        meant = fitting[:1] if is_one else fitting
        if self._neighbour and not (meant := neighbours(meant[0], objects)):
            self.reason = "nothing stands beside what is meant"
            return
        self._chosen, self.reason = Chosen(objects=tuple(meant)), ""
