"""Where the camera is above the table, for images that come without its pose.

The table is the plane that most of the image is near to, found by sampling three pixels at a time
(Fischler and Bolles, "Random sample consensus", 1981) and then fitted to all that are near.
"""

from __future__ import annotations

import numpy as np
from pinocchio import SE3

from perception.arrays import Array, Image
from perception.frame import Intrinsics

_STRIDE = 6  # every so many pixels are looked at
_SAMPLES = 300
_NEAR = 0.006  # so near to the plane belongs to it [m]
_LEAST = 0.15  # share of the pixels that must belong to it


class NoTableError(Exception):
    """No plane was found; the text says why."""


def camera_above_table(depth: Image, intrinsics: Intrinsics) -> SE3:
    """Pose of the camera in a world whose floor, z = 0, is the table.

    Its origin is the point of the table that the middle of the image shows; x is along u.

    Args:
        depth: (H, W) depth along the optical axis [m]; NaN where missing.
        intrinsics: the camera's pinhole model.

    Raises:
        NoTableError: too little of the image is level.
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
    near = np.abs((points - centre) @ normal) < _NEAR
    if near.mean() < _LEAST:
        raise NoTableError(f"only {100 * near.mean():.0f} % of the image lies in one plane")
    up = -normal * np.sign(normal[2])
    if up[2] > -0.25:
        raise NoTableError("the largest plane in sight is a wall, not a table")
    x = np.array([1.0, 0.0, 0.0]) - up[0] * up
    x /= np.linalg.norm(x)
    rotation = np.stack([x, np.cross(up, x), up])  # rows: axes of the world as the camera sees them
    middle = np.array([0.0, 0.0, (centre @ up) / up[2]])
    return SE3(rotation, -rotation @ middle)


def _plane(points: Array) -> tuple[Array, Array]:
    """A point and the unit normal of the plane that most points are near to."""
    rng = np.random.default_rng(0)
    best, kept = -1, points
    for corners in points[rng.integers(len(points), size=(_SAMPLES, 3))]:
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        length = np.linalg.norm(normal)
        if length < 1e-9:
            continue
        near = np.abs((points - corners[0]) @ (normal / length)) < _NEAR
        if near.sum() > best:
            best, kept = int(near.sum()), points[near]
    for _ in range(2):
        centre = kept.mean(axis=0)
        normal = np.linalg.svd(kept - centre, full_matrices=False)[2][2]
        kept = points[np.abs((points - centre) @ normal) < _NEAR]
    return centre, normal
