"""Depth images by ray casting: primitives exactly, hulls and meshes by their triangles.

A ray through pixel (u, v) is t·(x, y, 1) in the camera frame, so t is the depth. In a primitive's
frame the ray starts at o and runs along d, and the entry is the smaller root of a linear or
quadratic equation in t. A shape is processed in strips of rows, whose temporaries fit the cache.
"""

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from config.arrays import Array, Image
from hw.sim.camera.triangles import Body, draw
from hw.sim.sim_object import Mesh, Surface, Visible
from robots import (
    GREY,
    Box,
    Capsule,
    Cylinder,
    Hull,
    Intrinsics,
    Plane,
    Shape,
    Sphere,
    half_extents,
)

Ids: TypeAlias = npt.NDArray[np.int16]
Entry: TypeAlias = Callable[[Any, Image, Image], Image]

NEAR = 0.01  # smallest depth that is rendered [m]

STRIP = 32768  # pixels processed at a time

_SIGNS = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)], dtype=float)
_EDGES = np.array(
    [(a, b) for a in range(8) for b in range(a) if (_SIGNS[a] != _SIGNS[b]).sum() == 1]
)


class DepthRenderer:
    """Renders depth images for one pinhole camera."""

    def __init__(self, intrinsics: Intrinsics) -> None:
        self._intrinsics = intrinsics
        u = np.arange(intrinsics.width)
        v = np.arange(intrinsics.height)
        self._x: Image = ((u - intrinsics.cx) / intrinsics.fx).astype(np.float32)[None, :]
        self._y: Image = ((v - intrinsics.cy) / intrinsics.fy).astype(np.float32)[:, None]

    def render(self, shapes: Sequence[Visible], wTc: SE3) -> Image:
        """(H, W) depth along the optical axis [m]; NaN where nothing is seen from outside."""
        return self._render(shapes, wTc, None)

    def render_with_ids(self, shapes: Sequence[Visible], wTc: SE3) -> tuple[Image, Ids]:
        """Depth, and (H, W) index into `shapes` of the nearest one, -1 where nothing is visible."""
        size = (self._intrinsics.height, self._intrinsics.width)
        ids = np.full(size, -1, dtype=np.int16)
        return self._render(shapes, wTc, ids), ids

    def _render(self, shapes: Sequence[Visible], wTc: SE3, ids: Ids | None) -> Image:
        size = (self._intrinsics.height, self._intrinsics.width)
        depth = np.full(size, np.inf, dtype=np.float32)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            visible = self._visible(shapes, wTc)
            for index, shape, rotation, origin, (u0, u1, v0, v1) in visible:
                if isinstance(shape, Hull | Mesh):
                    continue
                sides = rotation[2:] if isinstance(shape, Plane) else rotation
                rx, ry, rz = sides.T[:, :, None, None]
                across, down = rx * self._x[:, u0:u1], ry * self._y[v0:v1] + rz
                rows = max(1, STRIP // (u1 - u0))
                for top in range(v0, v1, rows):
                    strip = slice(top, min(top + rows, v1)), slice(u0, u1)
                    along = across + down[:, top - v0 : top - v0 + rows]
                    entry = _ENTRY[type(shape)](shape, origin, along)
                    window = depth[strip]
                    nearest = entry < window
                    nearest &= entry > NEAR
                    np.copyto(window, entry, where=nearest)
                    if ids is not None:
                        np.copyto(ids[strip], np.int16(index), where=nearest)
            bodies = [
                _in_camera(index, shape, wTc.actInv(shapes[index].pose))
                for index, shape, *_ in visible
                if isinstance(shape, Hull | Mesh)
            ]
            if bodies:
                draw(depth, ids, bodies, self._intrinsics, NEAR)
        np.copyto(depth, np.nan, where=np.isinf(depth))
        return depth

    def _visible(
        self, shapes: Sequence[Visible], wTc: SE3
    ) -> list[tuple[int, Shape | Mesh, Image, Image, tuple[int, int, int, int]]]:
        """Candidates: index, shape, sRc, camera in the shape's frame, image rectangle."""
        if not shapes:
            return []
        wRs = np.array([s.pose.rotation for s in shapes])
        sRc = wRs.transpose(0, 2, 1) @ wTc.rotation
        cPs = (np.array([s.pose.translation for s in shapes]) - wTc.translation) @ wTc.rotation
        origins = -np.einsum("nij,nj->ni", sRc, cPs)
        bodies = [s.mesh if isinstance(s, Surface) else s.shape for s in shapes]
        half = np.array([b.half if isinstance(b, Mesh) else half_extents(b) for b in bodies])
        rectangles = self._rectangles(half, sRc, cPs)
        rays, starts = sRc.astype(np.float32), origins.astype(np.float32)
        return [
            (i, body, rays[i], starts[i], (u0, u1, v0, v1))
            for i, (body, (u0, u1, v0, v1)) in enumerate(zip(bodies, rectangles, strict=True))
            if u0 < u1 and v0 < v1
        ]

    def _rectangles(self, half: Array, sRc: Array, cPs: Any) -> list[list[int]]:
        """(N, 4) u0, u1, v0, v1 around each box cut at the near plane; the image if infinite."""
        camera = self._intrinsics
        corners = (_SIGNS * np.where(np.isinf(half), 0.0, half)[:, None, :]) @ sRc + cPs[:, None]
        a, b = corners[:, _EDGES[:, 0]], corners[:, _EDGES[:, 1]]
        cut = (NEAR - a[..., 2:]) / (b[..., 2:] - a[..., 2:])
        crossing = a + cut * (b - a)
        points = np.concatenate([corners, crossing], axis=1)
        seen = np.concatenate([corners[..., 2] >= NEAR, (cut[..., 0] > 0) & (cut[..., 0] < 1)], 1)
        z = np.maximum(points[..., 2], 0.5 * NEAR)
        bounds = []
        for axis, f, c, size in (
            (0, camera.fx, camera.cx, camera.width),
            (1, camera.fy, camera.cy, camera.height),
        ):
            pixel = f * points[..., axis] / z + c
            low = np.where(seen, pixel, np.inf).min(axis=1)
            high = np.where(seen, pixel, -np.inf).max(axis=1)
            bounds += [
                np.clip(np.floor(low), 0, size).astype(int),
                np.clip(np.ceil(high) + 1, 0, size).astype(int),
            ]
        rectangles = np.stack(bounds, axis=1)
        rectangles[np.isinf(half[:, 0])] = (0, camera.width, 0, camera.height)
        return rectangles.tolist()  # type: ignore[no-any-return]


def painted(shapes: Sequence[Visible], ids: Ids) -> npt.NDArray[np.uint8]:
    """(H, W, 3) flat colours of rendered `shapes`, by their (H, W) `ids`; grey for -1."""
    # the last one is that of -1
    colours = np.array([*(shape.colour for shape in shapes), GREY], dtype=np.uint8)
    return colours[ids]


def _in_camera(number: int, shape: Hull | Mesh, cTs: SE3) -> Body:
    corners = shape.vertices @ cTs.rotation.T + cTs.translation
    return Body(number, corners, shape.triangles, isinstance(shape, Hull) or shape.closed)


def _box(box: Box, o: Image, along: Image) -> Image:
    """The last of the planes through which a ray enters; the directions are overwritten."""
    half = np.array(box.half, dtype=np.float32)
    near = np.where(o >= half, half, -half)  # rays that go away from it miss the box
    inverse = np.divide(np.float32(1.0), along, out=along)
    low = (near - o)[:, None, None] * inverse
    high = np.multiply((-near - o)[:, None, None], inverse, out=inverse)
    for axis in np.flatnonzero(np.abs(o) < half):  # it is between the planes: one is behind it
        np.maximum(low[axis], high[axis], out=high[axis])
        low[axis] = -np.inf
    entry: Image = np.maximum.reduce(low)
    np.copyto(entry, np.inf, where=entry > np.minimum.reduce(high))
    return entry


def _ball(radius: float, o: Image, dx: Image, dy: Image, dz: Image) -> Image:
    a = dx * dx + dy * dy + dz * dz
    b = o[0] * dx + o[1] * dy + o[2] * dz
    root = np.sqrt(b * b - a * (o @ o - np.float32(radius * radius)))
    entry: Image = (-b - root) / a
    entry[np.isnan(entry)] = np.inf
    return entry


def _tube(radius: float, half: float, o: Image, dx: Image, dy: Image, dz: Image) -> Image:
    """Round side of a cylinder, without its ends."""
    a = dx * dx + dy * dy
    b = o[0] * dx + o[1] * dy
    root = np.sqrt(b * b - a * (o[0] * o[0] + o[1] * o[1] - np.float32(radius * radius)))
    entry: Image = (-b - root) / a
    entry[~(np.abs(o[2] + entry * dz) <= np.float32(half))] = np.inf
    return entry


def _sphere(sphere: Sphere, o: Image, along: Image) -> Image:
    return _ball(sphere.radius, o, *along)


def _cylinder(cylinder: Cylinder, o: Image, along: Image) -> Image:
    dx, dy, dz = along
    entry = _tube(cylinder.radius, cylinder.half_length, o, dx, dy, dz)
    half = np.float32(cylinder.half_length)
    if abs(o[2]) > half:  # only then can a ray come in through an end, and only the near one
        end = (np.sign(o[2]) * half - o[2]) / dz
        x, y = o[0] + end * dx, o[1] + end * dy
        end[~(x * x + y * y <= np.float32(cylinder.radius**2))] = np.inf
        np.minimum(entry, end, out=entry)
    return entry


def _capsule(capsule: Capsule, o: Image, along: Image) -> Image:
    entry = _tube(capsule.radius, capsule.half_length, o, *along)
    for end in (-capsule.half_length, capsule.half_length):
        from_end = o - np.array([0.0, 0.0, end], dtype=np.float32)
        np.minimum(entry, _ball(capsule.radius, from_end, *along), out=entry)
    return entry


def _plane(_: Plane, o: Image, along: Image) -> Image:
    """Only the direction along its normal counts."""
    if o[2] <= 0.0:
        return np.full_like(along[-1], np.inf)
    entry: Image = -o[2] / along[-1]
    return entry


_ENTRY: dict[type, Entry] = {
    Box: _box,
    Sphere: _sphere,
    Cylinder: _cylinder,
    Capsule: _capsule,
    Plane: _plane,
}
