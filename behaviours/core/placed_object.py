"""Check by the camera whether a released object stands at its place, while the hand leaves."""

from enum import Enum
from math import inf
from typing import NamedTuple

import numpy as np

from behaviours.core.context import Context
from behaviours.core.directions import way_out
from behaviours.core.log import Carried
from config.arrays import Array
from hw import DepthFrame
from perception import ColourName, colour_name, differ, disc

_HIGHER = 0.004  # than the surface is what stands on it [m]
_LEAST = 0.02  # share of the points that an object covers at least
_EMPTY = 0.75  # share of the points through which the surface is seen where nothing stands
_RISEN = 0.025  # rise of the hand that tells a standing object from one that sticks to it [m]
_COMES_ALONG = 0.3  # share of that rise by which a standing object may seem to rise
_AGREE = 3  # frames that show nothing, taken from different heights of the hand
_LEFT = 0.3  # a hand that is this far from the release looks no more [m]
_CLEAR = 0.05  # a hand that has risen less may hide the object [m]


class Verdict(Enum):
    """What was seen since the fingers opened."""

    UNSEEN = "not seen"
    STANDS = "stands"
    GONE = "gone"


class _Look(NamedTuple):
    hand: float
    """Position of the hand along its way out [m]."""
    height: float
    """Of the object over the surface, the median [m]."""


class PlacedObjectWatch:
    """Looks at a place in every new frame until the object is seen there, or nothing.

    A standing object is higher than the surface seen before, and keeps its height in odometry
    while the hand rises; one that sticks to a finger rises too.

    Args:
        context: shared by the leaves.
        carried: the object; it counts as placed once it is seen to stand.
        centre: (3,) of the place, in odometry [m].
        radius: of the disc around it that is looked at [m].
        before: (P,) heights over the centre that were seen through the points of the disc before
            [m]; NaN where nothing was seen.
    """

    def __init__(
        self, context: Context, carried: Carried, centre: Array, radius: float, before: Array
    ) -> None:
        self._carried, self._centre, self._radius = carried, centre, radius
        self._bare = before
        self._since, self._before = context.state.stamp, context.state.oTb
        self._released = context.oTe.translation.copy()
        self._out = way_out(context.oTe.rotation)
        self._looks: list[_Look] = []
        self.empty = 0
        """Newest frames in a row that show nothing there."""
        self.verdict = Verdict.UNSEEN
        self.shown = -inf
        """Time of the newest frame that shows something standing there [s]."""
        self.other: ColourName | None = None
        """The colour of what stands there, if what was grasped by its colour has another one."""

    def look(self, context: Context) -> None:
        """Take the frame that is new in this tick, if there is one to believe."""
        state, vision = context.state, context.vision
        if context.now.relocalised:  # the place is where it was from the base
            moved = state.oTb * self._before.inverse()
            self._centre, self._released = moved.act(self._centre), moved.act(self._released)
            self._since = state.stamp
        self._before = state.oTb
        gone = np.linalg.norm(context.oTe.translation - self._released)
        if gone > _LEFT and self.verdict is not Verdict.UNSEEN:
            context.memory.placed_object = None  # nobody asks the camera for it any more
            return
        frame = vision.newest(self._since)
        if frame is None or frame.stamp <= self._since or vision.blindness(state.stamp):
            return
        self._since = frame.stamp
        with vision.timed():
            self.verdict = self._verdict(frame, context)
        if self.verdict is not Verdict.STANDS:
            self._carried.placed = None
        elif self._carried.placed is None:
            self._carried.placed = context.clock.now()

    def _verdict(self, frame: DepthFrame, context: Context) -> Verdict:
        """By this frame and those before it."""
        eye = context.robot.description.camera.eTc.inverse().translation
        hand = float(frame.oTc.act(eye) @ self._out)
        points = disc(self._centre, self._radius, len(self._bare))
        seen = frame.cloud.along_rays(points)
        height = seen[:, 2] - self._centre[2]
        is_over = np.linalg.norm(seen[:, :2] - self._centre[:2], axis=1) < self._radius
        high = is_over & (height > self._bare + _HIGHER)
        bare = np.abs(height - self._bare) <= _HIGHER
        if high.sum() >= _LEAST * len(points):
            self.empty, self.shown = 0, frame.stamp
            self._looks.append(look := _Look(hand, float(np.median(height[high]))))
            if any(_is_still(look, before) for before in self._looks):
                self.other = self._other_colour(frame, seen[high])
                return Verdict.STANDS
        elif bare.sum() >= _EMPTY * len(points) and hand - self._released @ self._out > _CLEAR:
            self.empty += 1
            if self.empty >= _AGREE:
                return Verdict.GONE
        return self.verdict

    def _other_colour(self, frame: DepthFrame, points: Array) -> ColourName | None:
        if frame.colour is None or self._carried.colour is None:
            return None
        u, v = np.rint(frame.cloud.project(points)).astype(int).T
        name = colour_name(*np.median(frame.colour[v, u], axis=0).tolist())
        return name if differ(name, self._carried.colour) else None


def _is_still(now: _Look, before: _Look) -> bool:
    moved = abs(now.hand - before.hand)
    return moved >= _RISEN and abs(now.height - before.height) < _COMES_ALONG * moved
