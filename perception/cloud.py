"""The cloud of a depth image: which pixels hold a depth, and their points, each computed once."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from config.arrays import Array, Image, Indices, Mask
from config.poses import OdometryPose
from perception.geometry import Camera, world_points

MAX_DEPTH = 5.0  # larger readings are missing [m]


class Pixels(NamedTuple):
    """N pixels of an image that hold a depth, row by row."""

    rows: Indices  # (N,) [px]
    columns: Indices  # (N,) [px]
    points: Array  # (N, 3) in odometry [m]


@dataclass(frozen=True, kw_only=True, eq=False)
class DepthCloud(Camera):
    """A camera and the depth image that it took: (H, W) along the optical axis [m]."""

    depth: Image
    _sampled: dict[tuple[int, int, int], Pixels] = field(default_factory=dict, repr=False)

    @cached_property
    def valid(self) -> Mask:
        """(H, W) which pixels hold a usable depth; NaN is none."""
        return np.asarray((self.depth > 0.0) & (self.depth < MAX_DEPTH))

    def every(self, step: int, row: int = 0, column: int = 0) -> Pixels:
        """Those of every n-th row and column, from the given ones on, that hold a depth."""
        key = step, row, column
        if key not in self._sampled:
            v, u = np.nonzero(self.valid[row::step, column::step])
            v, u = row + step * v, column + step * u
            self._sampled[key] = Pixels(v, u, self.points(v, u))
        return self._sampled[key]

    def points(self, rows: Indices, columns: Indices) -> Array:
        """(N, 3) points of pixels in odometry [m]; NaN where the depth is."""
        depth, u, v = self.depth[rows, columns], columns.astype(float), rows.astype(float)
        return world_points(depth, self.intrinsics, self.oTc, u, v)

    def along_rays(self, points: Array) -> Array:
        """(N, 3) measured points on the rays through (N, 3) points, in odometry [m]; else NaN."""
        seen = np.full(points.shape, np.nan)
        ahead = np.flatnonzero((points - self.oTc.translation) @ self.oTc.rotation[:, 2] > 0.0)
        u, v = np.rint(self.project(points[ahead])).T
        rows, columns = self.depth.shape
        inside = (u >= 0) & (u < columns) & (v >= 0) & (v < rows)
        ahead, u, v = ahead[inside], u[inside].astype(int), v[inside].astype(int)
        measured = self.depth[v, u] > 0.0  # neither NaN nor black
        seen[ahead[measured]] = self.points(v[measured], u[measured])
        return seen

    def part(self, rows: slice, columns: slice) -> DepthCloud:
        """The part of the image in some rows and columns, as if by a smaller camera."""
        depth, whole = self.depth[rows, columns], self.intrinsics
        intrinsics = replace(
            whole,
            width=depth.shape[1],
            height=depth.shape[0],
            cx=whole.cx - columns.start,
            cy=whole.cy - rows.start,
        )
        part = DepthCloud(intrinsics=intrinsics, oTc=self.oTc, depth=depth)
        part.__dict__["valid"] = self.valid[rows, columns]
        return part

    def measuring(self, depth: Image) -> DepthCloud:
        """The camera with another image."""
        return DepthCloud(intrinsics=self.intrinsics, oTc=self.oTc, depth=depth)

    def posed(self, oTc: OdometryPose) -> DepthCloud:
        """The same image of a camera elsewhere, or told in another frame."""
        other = DepthCloud(intrinsics=self.intrinsics, oTc=oTc, depth=self.depth)
        other.__dict__["valid"] = self.valid
        return other
