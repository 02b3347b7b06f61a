"""The objects that stand in a region, as most of a few frames show them."""

from __future__ import annotations

from collections import deque

import numpy as np

from behaviours.choice import Choice
from behaviours.context import Context
from behaviours.poses import Region
from behaviours.survey import map_of, unseen
from hw import DepthFrame
from perception import DetectedObjects, RecogniserError, consensus, segment_objects, with_classes

SMALLEST = 1e-4
"""A part of a region that was not seen and covers less than this does not count [m^2]."""
LOOKS = 3
"""Frames that are looked at; what more than half of them show counts."""


class ObjectsInSight:
    """Looks at a region, a frame after the other.

    Args:
        context: of the tree.
        region: whose floor objects stand on.
        choice: what is asked for, which says what has to be known of them.
    """

    def __init__(self, context: Context, region: Region, choice: Choice) -> None:
        self._context, self._region, self._choice = context, region, choice
        self.begin()

    def begin(self, since: float = -np.inf) -> None:
        """Begin anew, with frames from session time `since` [s] on."""
        self._since = since
        self._frames: deque[DepthFrame] = deque(maxlen=LOOKS)
        self._looks: deque[DetectedObjects] = deque(maxlen=LOOKS)

    @property
    def unseen(self) -> str:
        """What the frames do not show of what is there, in words; empty if that does not matter."""
        settings, region = self._context.settings, self._region
        seen = map_of(region, settings.counting, *self._frames)
        if not self._looks[-1] and seen.segments(SMALLEST):
            return f"what stands in {region.name} is too low to be told apart"
        return unseen(seen, region, SMALLEST, settings.view)

    def look(self) -> DetectedObjects | str | None:
        """Take the frame that is new in this tick, if there is one to believe.

        Returns:
            The objects; None as long as too few frames were seen; or why nothing can be told.
        """
        vision = self._context.vision
        frame = vision.new_frame()
        stale = frame is None or frame.stamp < self._since
        if frame is None or stale or vision.is_blind(self._context.state.stamp):
            return None
        with vision.timed():
            seen = _told_apart(frame, self._region, self._choice)
            if isinstance(seen, str):
                return seen
            self._looks.append(seen)
            self._frames.append(frame)
            if len(self._looks) < LOOKS:
                return None
            return _with_kinds(frame, consensus(self._looks), self._choice)


def look_once(frame: DepthFrame, region: Region, choice: Choice) -> DetectedObjects | str:
    """The objects that one frame shows; or why nothing can be told."""
    seen = _told_apart(frame, region, choice)
    return seen if isinstance(seen, str) else _with_kinds(frame, seen, choice)


def _told_apart(frame: DepthFrame, region: Region, choice: Choice) -> DetectedObjects | str:
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
