"""Detection of the objects in a region, by a majority of a few frames."""

from __future__ import annotations

from collections import deque

import numpy as np

from behaviours.context import Context
from behaviours.object_choice import Choice
from behaviours.parameter_types import Region
from behaviours.survey import region_map, unseen
from hw import DepthFrame
from perception import DetectedObjects, RecogniserError, consensus, segment_objects, with_classes

_SMALLEST = 1e-4  # an unseen part of a region that covers less does not count [m^2]
_FRAMES = 3  # of which a majority must show an object


class ObjectDetection:
    """Detects objects in the frames of successive ticks.

    Args:
        context: shared by the leaves.
        region: whose floor the objects stand on.
        choice: criteria, which say what has to be known of the objects.
    """

    def __init__(self, context: Context, region: Region, choice: Choice) -> None:
        self._context, self._region, self._choice = context, region, choice
        self.begin()

    def begin(self, since: float = -np.inf) -> None:
        """Start again, with frames from session time `since` [s] on."""
        self._since = since
        self._frames: deque[DepthFrame] = deque(maxlen=_FRAMES)
        self._objects: deque[DetectedObjects] = deque(maxlen=_FRAMES)

    @property
    def unseen(self) -> str:
        """What the frames do not show of the region; empty if that does not matter."""
        seen = region_map(self._region, *self._frames)
        if not self._objects[-1] and seen.segments(_SMALLEST):
            return f"what stands in {self._region.name} is too low to be told apart"
        return unseen(seen, self._region, _SMALLEST)

    def update(self) -> DetectedObjects | str | None:
        """Take the frame that is new in this tick, if it is valid.

        Returns:
            The objects; None until there are enough frames; or why detection is impossible.
        """
        vision = self._context.vision
        frame = vision.new_frame()
        stale = frame is None or frame.stamp < self._since
        if frame is None or stale or vision.is_blind(self._context.state.stamp):
            return None
        with vision.timed():
            seen = _segmented(frame, self._region, self._choice)
            if isinstance(seen, str):
                return seen
            self._objects.append(seen)
            self._frames.append(frame)
            if len(self._objects) < _FRAMES:
                return None
            return _with_kinds(frame, consensus(self._objects), self._choice)


def detect_once(frame: DepthFrame, region: Region, choice: Choice) -> DetectedObjects | str:
    """The objects in one frame; or why detection is impossible."""
    seen = _segmented(frame, region, choice)
    return seen if isinstance(seen, str) else _with_kinds(frame, seen, choice)


def _segmented(frame: DepthFrame, region: Region, choice: Choice) -> DetectedObjects | str:
    if choice.colour is not None and frame.colour is None:
        return "the camera of this robot sees no colours"
    seen = segment_objects(frame, region)
    return "no depth was measured" if seen is None else seen


def _with_kinds(
    frame: DepthFrame, objects: DetectedObjects, choice: Choice
) -> DetectedObjects | str:
    try:
        return objects if choice.kind is None else with_classes(frame, objects, choice.kind)
    except RecogniserError as error:
        return str(error)
