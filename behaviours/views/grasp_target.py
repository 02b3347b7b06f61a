"""The target of a grasp: any object in a region, or one that is chosen once and then followed."""

import numpy as np

from behaviours.core.context import Context
from behaviours.core.parameter_types import Region
from behaviours.views.objects import Choice, Chosen, ObjectDetection, detect_once, neighbours
from controller import Array
from perception import DetectedObject, GraspEstimate


class GraspTarget:
    """What `grasp` looks for grasps on.

    Args:
        context: shared by the leaves.
        within: a region, or a detected object.
        choice: among the objects of a region.
        neighbour: take what stands beside the chosen object instead.
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
        self._detection = None
        if isinstance(within, Region) and not choice.is_free:
            self._detection = ObjectDetection(context, within, choice)
        self.begin()

    def begin(self, since: float = -np.inf) -> None:
        """Choose again, by frames from session time `since` [s] on."""
        self.reason = ""
        """Why nothing is chosen; empty if something is, or no frame has come yet."""
        self._chosen: Chosen | None = None
        if self._detection is not None:
            self._detection.begin(since)
        if isinstance(self._within, DetectedObject):
            self._chosen = Chosen(objects=(self._within,))

    def track(self, now: float) -> GraspEstimate | None:
        """The grasp that `Vision.track` follows on it; None if nothing is chosen.

        Args:
            now: session time [s].
        """
        vision, within = self._context.vision, self._within
        if isinstance(within, Region) and self._choice.is_free:
            return vision.track(within, now)
        if self._chosen is None and self._detection is not None:
            self._choose(self._detection)
        if self._chosen is None:
            return None
        return vision.track(self._chosen, now)

    def centre(self) -> Array | None:
        """(3,) of the target, the largest of several, in the newest frame and the world [m]."""
        frame, base = self._context.vision.frame, self._context.state.wTb.translation
        if self._chosen is not None:
            return self._chosen.objects[0].position
        if frame is None or not isinstance(self._within, Region):
            return None
        with self._context.vision.timed():
            objects = detect_once(frame, self._within, self._choice)
        if isinstance(objects, str):
            return None
        fitting = self._choice.fitting(objects, base)
        return max(fitting, key=lambda one: one.area).position if fitting else None

    def _choose(self, detection: ObjectDetection) -> None:
        objects = detection.update()
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
