"""What a depth frame shows of a place: the surface to set something down on, or something else."""

from __future__ import annotations

from enum import Enum
from math import inf, nan
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from behaviours.aiming import camera_pose
from behaviours.context import Context
from behaviours.settings import SurfaceSettings
from hw import DepthFrame
from perception import disc, points_along_rays

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]


class Shows(Enum):
    """What there is at a place."""

    SURFACE = "surface"
    HIGHER = "higher"
    """Something that stands on the surface, or a surface that lies too high."""
    LOWER = "lower"
    """A surface that lies too low, or ends here."""
    UNSEEN = "unseen"
    """Too little of the place is in the picture, or measured."""


class Look(NamedTuple):
    """What one frame shows of a place."""

    shows: Shows
    height: float
    """Of that over where the surface has to be, the median [m]; NaN if unseen."""
    surface: Mask
    """(points,) through which of the points of the disc the surface is seen."""
    heights: Array
    """(points,) of what is seen through them over where the surface has to be [m]; else NaN."""


class SurfaceWatch:
    """Looks at a place with the wrist camera, on the way to it and down on it.

    Args:
        context: of the tree.
        centre: (3,) of the place, in the world [m].
        radius: of the disc that is looked at [m].
        reach_down: how far what is held, or the hand, reaches below the hand [m].
    """

    def __init__(self, context: Context, centre: Array, radius: float, reach_down: float) -> None:
        self._context, self._settings = context, context.settings.surface
        self._centre, self._radius, self._reach_down = centre, radius, reach_down
        self._known_since = context.state.stamp
        self._nothing = Look(
            Shows.UNSEEN,
            nan,
            np.zeros(self._settings.points, dtype=np.bool_),
            np.full(self._settings.points, nan),
        )
        self._forget()

    def _forget(self) -> None:
        self.heights = np.full(self._settings.points, nan)
        """(points,) over the centre, as they were seen last through the points of the disc [m]."""
        self._seen_at = np.full(self._settings.points, -inf)

    @property
    def has_seen_surface(self) -> bool:
        """Whether a short time ago the surface was seen nearly everywhere, at once or bit by bit.

        What is held hides a part from every frame, and in that part something may stand.
        """
        known = self._context.state.stamp - self._seen_at <= self._settings.memory
        return bool(known.mean() >= self._settings.least_known)

    def look(self) -> Look:
        """What the frame shows that is new in this tick; unseen if there is none to believe."""
        context, vision, settings = self._context, self._context.vision, self._settings
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
        lowest = float(hand) - self._reach_down - settings.below_hand
        with vision.timed():
            look = look_at(frame, self._centre, self._radius, lowest, settings)
        self._seen_at[look.surface] = frame.stamp
        measured = ~np.isnan(look.heights)
        self.heights[measured] = look.heights[measured]
        return look

    def _can_see(self) -> bool:
        """Whether the camera is neither too far from the place nor too near to it."""
        camera = camera_pose(self._context).translation - self._centre
        least = self._context.robot.description.camera.min_range
        return bool(camera[2] > least and np.linalg.norm(camera) < self._settings.far)


def look_at(
    frame: DepthFrame, centre: Array, radius: float, hand: float, settings: SurfaceSettings
) -> Look:
    """What a frame shows of a level disc where a surface has to be.

    Rays go from the camera through points spread evenly over the disc. Each tells whether the
    surface is there, whether it goes on below, or whether something over the disc stops it. A ray
    tells nothing if it has no depth or is stopped beside the disc or by the hand.

    Args:
        frame: from any direction.
        centre: (3,) of the disc, in the world [m].
        radius: of the disc [m].
        hand: height in the world from which on what is seen belongs to the hand [m].
        settings: what counts as the surface, and how much of it has to be seen.
    """
    points = disc(centre, radius, settings.points)
    seen = points_along_rays(frame, points)
    height = seen[:, 2] - centre[2]
    over_disc = np.linalg.norm(seen[:, :2] - centre[:2], axis=1) <= radius
    surface = np.abs(height) <= settings.tolerance
    groups = (
        (Shows.LOWER, height < -settings.tolerance, settings.stray),
        (
            Shows.HIGHER,
            (height > settings.tolerance) & over_disc & (seen[:, 2] < hand),
            settings.stray_higher,
        ),
        (Shows.SURFACE, surface, settings.least_seen),
    )
    for shows, rays, share in groups:
        if rays.sum() > share * len(points):
            return Look(shows, float(np.median(height[rays])), surface, height)
    return Look(Shows.UNSEEN, nan, surface, height)
