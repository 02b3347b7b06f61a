"""The camera's pose above a table, for images that come without one.

The table is the plane with the most inliers, found by RANSAC on three pixels at a time (Fischler
and Bolles, "Random sample consensus", 1981) and refitted to its inliers.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from robots import Array, Intrinsics

_STRIDE = 6  # only every sixth row and column is used, for speed [px]
_SAMPLES = 300  # of three points: enough for one free of outliers at 25 % inliers, to 1 %
_INLIER_DISTANCE = 0.006  # of the order of the depth noise at 1 m [m]
_MIN_INLIERS = 0.15  # share of the pixels


class NoTableError(Exception):
    """No table was found; the message says why."""


def camera_above_table(depth: npt.NDArray[np.float32], intrinsics: Intrinsics) -> SE3:
    """Pose of the camera in a world whose floor, z = 0, is the table.

    Its origin is the point of the table at the middle of the image; x is along u.

    Args:
        depth: (H, W) depth along the optical axis [m]; NaN where missing.
        intrinsics: the camera's pinhole model.

    Raises:
        NoTableError: no plane has enough inliers, or it is not a table.
    """
    height, width = depth.shape
    v, u = (each.ravel() for each in np.mgrid[0:height:_STRIDE, 0:width:_STRIDE])
    ray = np.stack(
        [
            (u - intrinsics.cx) / intrinsics.fx,
            (v - intrinsics.cy) / intrinsics.fy,
            np.ones(len(u)),
        ],
        axis=1,
    )
    points = ray * depth[v, u, None].astype(float)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < 50:
        raise NoTableError("hardly any depth was measured")
    centre, normal = _plane(points)
    near = np.abs((points - centre) @ normal) < _INLIER_DISTANCE
    if near.mean() < _MIN_INLIERS:
        raise NoTableError(f"only {100 * near.mean():.0f} % of the image lies in one plane")
    up = -normal * np.sign(normal[2])
    if up[2] > -0.25:
        raise NoTableError("the largest plane in sight is a wall, not a table")
    x = np.array([1.0, 0.0, 0.0]) - up[0] * up
    x /= np.linalg.norm(x)
    rotation = np.stack([x, np.cross(up, x), up])  # rows: axes of the world in the camera
    middle = np.array([0.0, 0.0, (centre @ up) / up[2]])
    return SE3(rotation, -rotation @ middle)


def _plane(points: Array) -> tuple[Array, Array]:
    """A point and the unit normal of the plane with the most inliers."""
    rng = np.random.default_rng(0)
    best, kept = -1, points
    for corners in points[rng.integers(len(points), size=(_SAMPLES, 3))]:
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        length = np.linalg.norm(normal)
        if length < 1e-9:
            continue
        near = np.abs((points - corners[0]) @ (normal / length)) < _INLIER_DISTANCE
        if near.sum() > best:
            best, kept = int(near.sum()), points[near]
    for _ in range(2):
        centre = kept.mean(axis=0)
        normal = np.linalg.svd(kept - centre, full_matrices=False)[2][2]
        kept = points[np.abs((points - centre) @ normal) < _INLIER_DISTANCE]
    return centre, normal
