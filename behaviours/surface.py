"""Detection of the surface at a place in a depth frame, before an object is set down on it."""

from __future__ import annotations

from enum import Enum
from math import inf, nan
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from behaviours.context import Context
from behaviours.viewpoint import camera_pose
from hw import DepthFrame
from perception import disc, points_along_rays

_FAR = 0.7  # the camera has to be nearer than this [m]
_POINTS = 300  # of the disc that is looked at
_TOLERANCE = 0.015  # height error of the surface [m]
_STRAY = 0.1  # share of the points that may be lower
_STRAY_HIGHER = 0.03  # share of the points that may be higher
_LEAST_SEEN = 0.3  # share of the points at which one frame has to show the surface
_LEAST_KNOWN = 0.9  # the same over several frames, as hand and object hide a part of each
_BELOW_HAND = 0.03  # a point this near to the lower end of the held object belongs to it [m]
_MEMORY = 2.0  # age of the frames that count [s]

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]


class Shows(Enum):
    """What a frame shows at a place."""

    SURFACE = "surface"
    HIGHER = "higher"
    """An object, or a surface that is too high."""
    LOWER = "lower"
    """A surface that is too low, or ends here."""
    UNSEEN = "unseen"
    """Too little of the place is in the picture, or measured."""


class Look(NamedTuple):
    """What one frame shows of a place."""

    shows: Shows
    height: float
    """Median over the expected surface [m]; NaN if unseen."""
    surface: Mask
    """(points,) of the disc, through which the surface is seen."""
    heights: Array
    """(points,) over the expected surface [m]; NaN where nothing is seen."""


class SurfaceWatch:
    """Looks at a place with the wrist camera, while the hand moves over it and down.

    Args:
        context: shared by the leaves.
        centre: (3,) of the place, in the world [m].
        radius: of the disc that is looked at [m].
        reach_down: how far the held object, or the fingers, reach below the hand [m].
    """

    def __init__(self, context: Context, centre: Array, radius: float, reach_down: float) -> None:
        self._context = context
        self.centre, self._radius, self._reach_down = centre, radius, reach_down
        self._known_since = context.state.stamp
        self._nothing = Look(
            Shows.UNSEEN, nan, np.zeros(_POINTS, dtype=np.bool_), np.full(_POINTS, nan)
        )
        self._forget()

    def _forget(self) -> None:
        self.heights = np.full(_POINTS, nan)
        """(points,) over the centre, as seen last through the points of the disc [m]."""
        self._seen_at = np.full(_POINTS, -inf)

    @property
    def has_seen_surface(self) -> bool:
        """Whether recent frames have together shown nearly all of the surface."""
        known = self._context.state.stamp - self._seen_at <= _MEMORY
        return bool(known.mean() >= _LEAST_KNOWN)

    def look(self) -> Look:
        """What the new frame of this tick shows; unseen if there is no valid one."""
        context, vision = self._context, self._context.vision
        if context.relocalised:  # what was seen before is not where it was
            self._known_since = context.state.stamp
            self._forget()
        if not self._can_see():
            return self._nothing
        frame = vision.new_frame()
        if frame is None or frame.stamp < self._known_since:
            return self._nothing
        if vision.is_blind(context.state.stamp):
            return self._nothing
        hand = frame.wTc.act(context.robot.description.camera.eTc.inverse().translation)[2]
        lowest = float(hand) - self._reach_down - _BELOW_HAND
        with vision.timed():
            look = look_at(frame, self.centre, self._radius, lowest)
        self._seen_at[look.surface] = frame.stamp
        measured = ~np.isnan(look.heights)
        self.heights[measured] = look.heights[measured]
        return look

    def _can_see(self) -> bool:
        """Whether the camera is within range of the place."""
        camera = camera_pose(self._context).translation - self.centre
        least = self._context.robot.description.camera.min_range
        return bool(camera[2] > least and np.linalg.norm(camera) < _FAR)


def look_at(frame: DepthFrame, centre: Array, radius: float, hand: float) -> Look:
    """What a frame shows of a level disc where a surface is expected.

    Rays go from the camera through points spread evenly over the disc. Each ends at the surface,
    below it, or at an object over the disc; rays without depth, and those that end beside the disc
    or at the hand, do not count.

    Args:
        frame: from any direction.
        centre: (3,) of the disc, in the world [m].
        radius: of the disc [m].
        hand: height in the world from which on points belong to the hand [m].
    """
    points = disc(centre, radius, _POINTS)
    seen = points_along_rays(frame, points)
    height = seen[:, 2] - centre[2]
    over_disc = np.linalg.norm(seen[:, :2] - centre[:2], axis=1) <= radius
    surface = np.abs(height) <= _TOLERANCE
    groups = (
        (Shows.LOWER, height < -_TOLERANCE, _STRAY),
        (Shows.HIGHER, (height > _TOLERANCE) & over_disc & (seen[:, 2] < hand), _STRAY_HIGHER),
        (Shows.SURFACE, surface, _LEAST_SEEN),
    )
    for shows, rays, share in groups:
        if rays.sum() > share * len(points):
            return Look(shows, float(np.median(height[rays])), surface, height)
    return Look(Shows.UNSEEN, nan, surface, height)
