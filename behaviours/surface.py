"""What a depth frame shows of a place: the surface to set something down on, or something else."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from behaviours.settings import SurfaceSettings
from hw import DepthFrame
from perception import Camera, world_points

Array = npt.NDArray[np.float64]


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
    disc = _disc(centre, radius, settings.points)
    seen = _seen_through(frame, disc)
    height = seen[:, 2] - centre[2]
    over_disc = np.linalg.norm(seen[:, :2] - centre[:2], axis=1) <= radius
    groups = (
        (Shows.LOWER, height < -settings.tolerance, settings.stray),
        (
            Shows.HIGHER,
            (height > settings.tolerance) & over_disc & (seen[:, 2] < hand),
            settings.stray,
        ),
        (Shows.SURFACE, np.abs(height) <= settings.tolerance, settings.least_seen),
    )
    for shows, rays, share in groups:
        if rays.sum() > share * len(disc):
            return Look(shows, float(np.median(height[rays])))
    return Look(Shows.UNSEEN, np.nan)


def _disc(centre: Array, radius: float, count: int) -> Array:
    """(count, 3) points spread evenly over a level disc: the spiral of a sunflower."""
    n = np.arange(count) + 0.5
    r, turn = radius * np.sqrt(n / count), n * np.pi * (3.0 - np.sqrt(5.0))
    flat: Array = np.stack([r * np.cos(turn), r * np.sin(turn), np.zeros(count)], axis=1)
    return flat + centre


def _seen_through(frame: DepthFrame, points: Array) -> Array:
    """(N, 3) what is seen on the rays through (N, 3) points, in the world [m]; else NaN."""
    seen = np.full(points.shape, np.nan)
    ahead = np.flatnonzero((points - frame.wTc.translation) @ frame.wTc.rotation[:, 2] > 0.0)
    camera = Camera(intrinsics=frame.intrinsics, wTc=frame.wTc)
    u, v = np.rint(camera.project(points[ahead])).T
    rows, columns = frame.depth.shape
    inside = (u >= 0) & (u < columns) & (v >= 0) & (v < rows)
    ahead, u, v = ahead[inside], u[inside], v[inside]
    depth = frame.depth[v.astype(int), u.astype(int)]
    measured = depth > 0.0  # neither NaN nor black
    seen[ahead[measured]] = world_points(
        depth[measured], frame.intrinsics, frame.wTc, u[measured], v[measured]
    )
    return seen
