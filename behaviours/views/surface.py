"""Detection of the surface at a place in a depth frame, before an object is set down on it."""

from enum import Enum
from math import inf, nan
from typing import NamedTuple

import numpy as np

from behaviours.core.context import Context
from behaviours.core.directions import way_out
from behaviours.views.viewpoint import camera_pose
from config.arrays import Array, Mask
from hw import DepthFrame
from perception import Workspace, disc

_FAR = 0.7  # the camera has to be nearer than this [m]
_POINTS = 300  # of the disc that is looked at
_TOLERANCE = 0.015  # height error of the surface [m]
_STRAY = 0.1  # share of the points that may be lower
_STRAY_HIGHER = 0.03  # share of the points that may be higher
_LEAST_SEEN = 0.3  # share of the points at which one frame has to show the surface
_LEAST_KNOWN = 0.9  # the same over several frames, as hand and object hide a part of each
_NOTICEABLE = 0.003  # difference of two heights that the same camera saw [m]
_FLOOR, _FLOOR_SEEN = 0.15, 0.1  # radius around a grasp, and share of it that shows the floor [m]
_LEVEL = 0.003  # heights that differ by less belong to one level [m]
_BESIDE = 0.1  # radius around a place in which the surface must not end unnoticed [m]
_BELOW_HAND = 0.03  # a point this near to the lower end of the held object belongs to it [m]
_MEMORY = 2.0  # age of the frames that count [s]


class Shows(Enum):
    """What a frame shows at a place."""

    SURFACE = "surface"
    HIGHER = "higher"
    """An object, or a surface that is too high."""
    LOWER = "lower"
    """A surface that is too low, or ends here."""
    UNSEEN = "unseen"
    """Too little of the place is in the picture, or measured."""


class Edge(NamedTuple):
    """Where a surface ends beside a place."""

    distance: float
    """From the place; negative if that lies beyond the edge [m]."""
    inwards: Array
    """(3,) horizontal unit vector in odometry, from the edge onto the surface."""


class Look(NamedTuple):
    """What one frame shows of a place."""

    shows: Shows
    height: float
    """Median over the expected surface [m]; NaN if unseen."""
    surface: Mask
    """(points,) of the disc, through which the surface is seen."""
    heights: Array
    """(points,) over the expected surface [m]; NaN where nothing is seen."""
    edge: Edge | None = None
    """Of the surface, if it is seen near the place."""


class SurfaceWatch:
    """Looks at a place with the wrist camera, while the hand moves over it and down.

    Args:
        context: shared by the leaves.
        radius: of the disc that is looked at [m].
        reach_down: how far the held object, or the fingers, reach below the hand [m].
    """

    def __init__(self, context: Context, radius: float, reach_down: float) -> None:
        self._context, self._radius, self._reach_down = context, radius, reach_down
        self._error = context.log.floor_error
        self._height = 0.0
        self.centre = np.zeros(3)
        """(3,) where the camera should see the place, in odometry [m]."""
        self._known_since = context.state.stamp
        self._nothing = Look(
            Shows.UNSEEN, nan, np.zeros(_POINTS, dtype=np.bool_), np.full(_POINTS, nan)
        )
        self._forget()

    def _forget(self) -> None:
        self.heights = np.full(_POINTS, nan)
        """(points,) over the centre, as seen last through the points of the disc [m]."""
        self._seen_at = np.full(_POINTS, -inf)

    def aim(self, place: Array) -> None:
        """Look at a place (3,) of the map, in odometry [m]."""
        self.centre = place + np.array([0.0, 0.0, self._expected])

    @property
    def _expected(self) -> float:
        """How much higher than on the map the camera should see the surface [m]."""
        return _noticeable(self._error or 0.0)

    @property
    def higher(self) -> float:
        """How much higher than on the map the surface is, by the newest frame that shows it [m].

        Compared with the surface that the object stood on, which the same camera saw. Zero if that
        was not seen, or the difference could be an error of the camera.
        """
        if self._error is None:
            return 0.0
        return _noticeable(self._height + self._expected - self._error)

    @property
    def has_seen_surface(self) -> bool:
        """Whether recent frames have together shown nearly all of the surface."""
        known = self._context.state.stamp - self._seen_at <= _MEMORY
        return bool(known.mean() >= _LEAST_KNOWN)

    def look(self) -> Look:
        """What the new frame of this tick shows; unseen if there is no valid one."""
        context, vision = self._context, self._context.vision
        if context.now.relocalised:  # what was seen before is not where it was
            self._known_since = context.state.stamp
            self._forget()
        if not self._can_see():
            return self._nothing
        frame = vision.new_frame()
        if frame is None or frame.stamp < self._known_since:
            return self._nothing
        if vision.blindness(context.state.stamp):
            return self._nothing
        hand = frame.oTc.act(context.robot.description.camera.eTc.inverse().translation)[2]
        lowest = float(hand) - self._reach_down - _BELOW_HAND
        with vision.timed():
            look = look_at(frame, self.centre, self._radius, lowest)
        if look.shows is Shows.SURFACE:
            self._height = look.height
        self._seen_at[look.surface] = frame.stamp
        measured = ~np.isnan(look.heights)
        self.heights[measured] = look.heights[measured]
        return look

    def _can_see(self) -> bool:
        """Whether the camera is within range of the place."""
        camera = camera_pose(self._context).translation - self.centre
        away = camera @ way_out(self._context.oTe.rotation)
        least = self._context.robot.description.camera.min_range
        return bool(away > least and np.linalg.norm(camera) < _FAR)


def _noticeable(height: float) -> float:
    return height if abs(height) > _NOTICEABLE else 0.0


def look_at(frame: DepthFrame, centre: Array, radius: float, hand: float) -> Look:
    """What a frame shows of a level disc where a surface is expected.

    Rays go from the camera through points spread evenly over the disc. Each ends at the surface,
    below it, or at an object over the disc; rays without depth, and those that end beside the disc
    or at the hand, do not count.

    Args:
        frame: from any direction.
        centre: (3,) of the disc, in odometry [m].
        radius: of the disc [m].
        hand: height in odometry from which on points belong to the hand [m].
    """
    edge = edge_near(frame, centre)
    points = disc(centre, radius, _POINTS)
    seen = frame.cloud.along_rays(points)
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
            return Look(shows, float(np.median(height[rays])), surface, height, edge)
    return Look(Shows.UNSEEN, nan, surface, height, edge)


def edge_near(frame: DepthFrame, centre: Array) -> Edge | None:
    """The edge of the surface around a place (3,) in odometry [m], if a frame shows one.

    A ray through a point at the height of the surface meets it, or passes over its edge. The edge
    is where the seen surface ends: beside it, a stereo camera may see nothing.
    """
    points = disc(centre, _BESIDE, _POINTS)
    height = frame.cloud.along_rays(points)[:, 2] - centre[2]
    surface, lower = np.abs(height) <= _TOLERANCE, height < -_TOLERANCE
    if surface.mean() <= _STRAY or lower.mean() <= _STRAY_HIGHER:
        return None
    inwards = points[surface].mean(axis=0) - points[lower].mean(axis=0)
    inwards /= np.linalg.norm(inwards)
    ends = np.quantile((points[surface] - centre) @ inwards, _STRAY_HIGHER)
    return Edge(-float(ends), inwards)


def floor_error(frame: DepthFrame | None, grasp: Array, within: Workspace) -> float | None:
    """How much higher a camera sees the floor around a grasp than the map has it [m].

    The errors of where the camera is on the hand, and of its depths, are the same where it sees
    another surface from as far away; so a difference of two such heights is free of them.

    Args:
        frame: that shows the grasp, if there is one.
        grasp: (3,) its centre, in odometry [m].
        within: has the height of the floor on the map.

    Returns:
        The lowest level near that height; None where hardly any of it is seen.
    """
    if frame is None:
        return None
    points = disc(np.array([*grasp[:2], within.floor]), _FLOOR, _POINTS)
    heights = frame.cloud.along_rays(points)[:, 2] - within.floor
    near = heights[np.abs(heights) <= _TOLERANCE]
    if len(near) < _FLOOR_SEEN * _POINTS:
        return None
    lowest = np.quantile(near, _FLOOR_SEEN)
    return float(np.median(near[np.abs(near - lowest) <= _LEVEL]))
