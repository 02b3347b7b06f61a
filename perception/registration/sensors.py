"""What a laser and a depth camera measured of their surroundings, and how wrong that may be."""

from dataclasses import dataclass
from math import ceil, radians, sqrt

import numpy as np
from pinocchio import SE3

from perception.frame import Array, Image
from perception.geometry import world_points
from robots import Intrinsics

_PIXELS = 8000
"""Of an image that are looked at, about."""


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


def depth_cloud(
    depth: Image,
    intrinsics: Intrinsics,
    bTc: SE3,
    *,
    count: int = 250,
    ranges: tuple[float, float] = (0.15, 2.5),
    above: float = 0.03,
    errors: SensorErrors = DEPTH_CAMERA,
) -> Cloud:
    """Points of a depth image that stand above the floor, thinned evenly.

    Args:
        depth: (H, W) along the optical axis [m]; NaN where missing.
        intrinsics: the camera's pinhole model.
        bTc: camera in the base at capture.
        count: about how many points at most.
        ranges: smallest and largest depth that is used [m].
        above: lowest height that is used, which leaves out the floor [m].
        errors: of the camera.
    """
    step = max(1, ceil(sqrt(depth.size / _PIXELS)))
    v, u = np.mgrid[step // 2 : depth.shape[0] : step, step // 2 : depth.shape[1] : step]
    seen = depth[v, u]
    used = (seen > ranges[0]) & (seen < ranges[1])
    points = world_points(seen[used], intrinsics, bTc, u[used], v[used])
    points = points[points[:, 2] > above]
    return Cloud(points[:: max(1, ceil(len(points) / count))], bTc.translation.copy(), errors)
