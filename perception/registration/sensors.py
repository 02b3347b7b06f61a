"""What a laser and a depth camera measured of their surroundings, and how wrong that may be."""

from dataclasses import dataclass, field
from math import ceil, radians, sqrt

import numpy as np
from pinocchio import SE3

from config.arrays import Array, Image
from perception.geometry import world_points
from robots import Intrinsics, LaserDescription

_PIXELS, _COUNT = 8000, 250  # of an image that are looked at, and of these that are used, about
_NEAREST, _FARTHEST = 0.15, 2.5  # depths that are used [m]
_FLOOR = 0.03  # lower points belong to the floor [m]


@dataclass(frozen=True, kw_only=True)
class SensorErrors:
    """Standard deviations of what is wrong with the points of a sensor.

    The errors from `offset` on are common to all of its points: no number of points averages them.
    """

    noise: float
    """Of each point [m]."""
    noise_growth: float
    """Of each point, times the square of its range [1/m]."""
    offset: float
    """Of where the sensor is said to be, along each axis [m]."""
    turn: float
    """Of where it is said to look, about each axis [rad]."""
    scale: float
    """Of its ranges, as a factor."""


LASER = SensorErrors(noise=0.01, noise_growth=0.0, offset=0.002, turn=radians(0.1), scale=0.002)
DEPTH_CAMERA = SensorErrors(
    noise=0.003, noise_growth=0.003, offset=0.003, turn=radians(0.6), scale=0.0075
)


@dataclass(frozen=True, eq=False)
class Cloud:
    """Points that one sensor measured at one time."""

    points: Array
    """(N, 3) in the base frame at capture [m]."""
    eye: Array
    """(3,) where the sensor measures from, in the base frame [m]."""
    errors: SensorErrors
    ends: Array = field(default_factory=lambda: np.zeros((0, 3)))
    """(M, 3) where some of its rays end, on the floor and out of reach too, in the base [m]."""


def scan_cloud(ranges: Array, points: Array, laser: LaserDescription) -> Cloud:
    """A scan of ranges (n,) whose beams end at points (n, 3) in the base [m], as `LaserReading`."""
    seen, ends = points[np.isfinite(ranges)], points[~np.isnan(ranges)]
    return Cloud(seen, laser.bTs.translation, LASER, ends)


def depth_cloud(depth: Image, intrinsics: Intrinsics, bTc: SE3) -> Cloud:
    """Points of a depth image that stand above the floor, thinned evenly.

    Args:
        depth: (H, W) along the optical axis [m]; NaN where missing.
        intrinsics: the camera's pinhole model.
        bTc: camera in the base at capture.
    """
    step = max(1, ceil(sqrt(depth.size / _PIXELS)))
    v, u = np.mgrid[step // 2 : depth.shape[0] : step, step // 2 : depth.shape[1] : step]
    seen = depth[v, u]
    used = (seen > _NEAREST) & (seen < _FARTHEST)
    points = world_points(seen[used], intrinsics, bTc, u[used], v[used])
    ends, points = _thinned(points), _thinned(points[points[:, 2] > _FLOOR])
    return Cloud(points, bTc.translation.copy(), DEPTH_CAMERA, ends)


def _thinned(points: Array) -> Array:
    return points[:: max(1, ceil(len(points) / _COUNT))]
