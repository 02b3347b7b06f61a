"""Rasterization of triangles in depth images, exact at the ray of each pixel.

With corners A, B, C in pixels times depth, the ray of pixel d = (u, v, 1) meets a triangle if the
products d·(B×C), d·(C×A), d·(A×B) have one sign, at the depth A·(B×C) / d·((B-A)×(C-A)): 2D
homogeneous rasterization (Olano and Greer, 1997), without clipping. Along a row all of these are
linear, so every triangle becomes a span of pixels in each row. Triangles that share an edge compute
the same end of their spans, so no ray slips between them.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from config.arrays import Image, Indices, Mask
from robots import Array, Intrinsics, Triangles


class Body(NamedTuple):
    """Triangles in front of a camera."""

    number: int  # in `ids`
    corners: Array  # (V, 3) in the camera [m]
    triangles: Triangles  # (T, 3) numbers of the corners, counter-clockwise as seen from outside
    closed: bool  # visible from outside only


def draw(
    depth: Image,
    ids: npt.NDArray[np.int16] | None,
    bodies: Sequence[Body],
    camera: Intrinsics,
    near: float,
) -> None:
    """Draw bodies into a depth image (H, W) [m], and its `ids`, where they are nearer."""
    offsets = np.cumsum([0, *(len(body.corners) for body in bodies)])
    corners = np.concatenate([body.corners for body in bodies])
    triangles = np.concatenate([b.triangles + o for b, o in zip(bodies, offsets, strict=False)])
    counts = [len(body.triangles) for body in bodies]
    closed = np.repeat([body.closed for body in bodies], counts)
    at, pixel, triangle = _crossed(corners, triangles, closed, camera, near)
    flat = depth.reshape(-1)
    (nearer,) = np.nonzero(at < flat[pixel])
    at, pixel = at[nearer], pixel[nearer]
    np.minimum.at(flat, pixel, at)
    if ids is not None:
        shown = flat[pixel] == at
        owner = np.repeat([body.number for body in bodies], counts)[triangle[nearer[shown]]]
        ids.reshape(-1)[pixel[shown]] = owner


def _crossed(
    in_camera: Array,
    triangles: Triangles,
    closed: Mask,
    camera: Intrinsics,
    near: float,
) -> tuple[Image, Indices, Indices]:
    """All rays that meet triangles: (P,) depths [m], numbers of pixels and of triangles."""
    z = in_camera[:, 2]
    corners = np.stack(
        [
            camera.fx * in_camera[:, 0] + camera.cx * z,
            camera.fy * in_camera[:, 1] + camera.cy * z,
            z,
        ],
        axis=1,
    )
    low, high = _rows(corners[:, 1], z, triangles, camera.height, near)
    a, b, c = (corners[triangles[:, i]] for i in range(3))
    sides = np.stack([_cross(b, c), _cross(c, a), _cross(a, b)], axis=1)
    determinant = np.einsum("ij,ij->i", a, sides[:, 0])
    faces_us = (determinant < 0.0) | ((determinant > 0.0) & ~closed)
    (seen,) = np.nonzero((low <= high) & faces_us)
    sides, determinant = sides[seen], determinant[seen]

    which, v = _expanded(low[seen], high[seen])
    inwards = sides * np.sign(determinant)[:, None, None]
    slope = inwards[which, :, 0]
    rest = inwards[which, :, 1] * v[:, None] + inwards[which, :, 2]
    end = -rest / slope
    first = np.where(slope > 0.0, end, -np.inf).max(axis=1)
    last = np.where(slope < 0.0, end, np.inf).min(axis=1)
    outside = ((slope == 0.0) & (rest < 0.0)).any(axis=1)
    first = np.ceil(np.clip(first, 0.0, camera.width)).astype(np.int64)
    last = np.floor(np.clip(last, -1.0, camera.width - 1.0)).astype(np.int64)
    last[outside] = -1
    (some,) = np.nonzero(first <= last)
    which, v = which[some], v[some]

    span, u = _expanded(first[some], last[some])
    normal, tall = sides.sum(axis=1)[which], determinant[which]
    along, start = normal[:, 0] / tall, (normal[:, 1] * v + normal[:, 2]) / tall
    inverse = along[span] * u + start[span]
    ahead = (inverse > 0.0) & (inverse < 1.0 / near)
    span, pixel = span[ahead], ((v * camera.width)[span] + u)[ahead]
    return (1.0 / inverse[ahead]).astype(np.float32), pixel, seen[which][span]


def _rows(
    y: Array, z: Array, triangles: Triangles, height: int, near: float
) -> tuple[Indices, Indices]:
    """First and last row (T,) of each triangle; all rows where it crosses the near plane."""
    ahead = z > near
    row = y / np.where(ahead, z, 1.0)
    corner, in_front = row[triangles], ahead[triangles]
    low, high = np.ceil(corner.min(axis=1)), np.floor(corner.max(axis=1))
    crossing = ~in_front.all(axis=1)
    low[crossing], high[crossing] = 0.0, height - 1.0
    high[~in_front.any(axis=1)] = -1.0
    low = np.clip(low, 0.0, height).astype(np.int64)
    return low, np.clip(high, -1.0, height - 1.0).astype(np.int64)


def _expanded(first: Indices, last: Indices) -> tuple[Indices, Indices]:
    """All integers of ranges (N,), both ends included: number of the range, and the integers."""
    count = np.maximum(last - first + 1, 0)
    which = np.repeat(np.arange(len(first)), count)
    before = np.cumsum(count) - count
    return which, np.arange(len(which)) - (before - first)[which]


def _cross(a: Array, b: Array) -> Array:
    """Cross products (N, 3), several times as fast as `np.cross`."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=1)
