"""Pinhole camera geometry: from pixels to points in odometry and back."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from config.arrays import Array
from config.poses import OdometryPose
from robots import Intrinsics

FloatArray: TypeAlias = npt.NDArray[np.floating]

CAMERA_UP = 0.17
"""Where one side of a tilted hand is higher than this share of their distance, it has the camera.
"""


def world_points(
    depth: FloatArray, intrinsics: Intrinsics, oTc: OdometryPose, u: Array, v: Array
) -> Array:
    """(..., 3) points in odometry of pixels [m]; NaN where the depth is.

    `u` and `v` are columns and rows in the full image, broadcast to `depth` [px].
    """
    return np.stack(world_maps(depth.astype(float), intrinsics, oTc, u, v), axis=-1)


def world_maps(
    depth: FloatArray,
    intrinsics: Intrinsics,
    oTc: OdometryPose,
    u: Array,
    v: Array,
    axes: Sequence[int] = (0, 1, 2),
) -> list[FloatArray]:
    """World coordinates of pixels as separate arrays [m], in the precision of `depth`.

    Arguments as of `world_points`; `axes` selects x (0), y (1) and z (2).
    """
    x = ((u - intrinsics.cx) / intrinsics.fx).astype(depth.dtype)
    y = ((v - intrinsics.cy) / intrinsics.fy).astype(depth.dtype)
    rotation, translation = (part.astype(depth.dtype) for part in (oTc.rotation, oTc.translation))
    maps = []
    for axis in axes:
        values = rotation[axis, 0] * x + (rotation[axis, 1] * y + rotation[axis, 2])
        values = np.multiply(depth, values, out=values if values.shape == depth.shape else None)
        values += translation[axis]
        maps.append(values)
    return maps


@dataclass(frozen=True, kw_only=True, eq=False)
class Camera:
    """A pinhole camera in odometry."""

    intrinsics: Intrinsics
    oTc: OdometryPose

    def project(self, points: Array) -> Array:
        """(N, 2) pixels of (N, 3) points in odometry."""
        x, y, z = ((points - self.oTc.translation) @ self.oTc.rotation).T
        camera = self.intrinsics
        return np.stack([camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy], axis=1)

    def at_height(self, pixel: Array, height: Array) -> Array:
        """(N, 3) points where the rays of (N, 2) pixels meet horizontal planes at (N,) heights."""
        camera = self.intrinsics
        ray = np.stack(
            [
                (pixel[:, 0] - camera.cx) / camera.fx,
                (pixel[:, 1] - camera.cy) / camera.fy,
                np.ones(len(pixel)),
            ],
            axis=1,
        )
        ray = ray @ self.oTc.rotation.T
        distance = (height - self.oTc.translation[2]) / ray[:, 2]
        return np.asarray(self.oTc.translation + ray * distance[:, None])

    def closing_direction(self, pixel: Array, angle: Array, height: Array) -> Array:
        """(N,) horizontal closing directions, from x towards y in odometry [rad].

        Of angles (N,) in the image, from u towards v [rad], at pixels (N, 2) that show planes at
        heights (N,) [m].
        """
        step = 4.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        line = self.at_height(pixel + step, height) - self.at_height(pixel - step, height)
        return np.arctan2(line[:, 1], line[:, 0])


def grasp_pose(
    x: float, y: float, z: float, direction: float, oTc: OdometryPose, up: Array | None = None
) -> SE3:
    """WTg of a grasp from straight above, turned by half a turn if that turns the camera less.

    `direction` is the closing direction, from x towards y in odometry [rad]. Of a tilted grasp all
    is in a; its camera shall be above the hand, if `up` (3,) tells so: the world's vertical in a,
    or its opposite for a camera at -x of the hand.
    """
    x_closing, y_closing = np.cos(direction), np.sin(direction)
    better = x_closing * oTc.rotation[0, 0] + y_closing * oTc.rotation[1, 0]
    if up is not None and abs(upwards := x_closing * up[1] - y_closing * up[0]) > CAMERA_UP:
        better = upwards
    if better < 0.0:
        x_closing, y_closing = -x_closing, -y_closing
    rotation = np.array(
        [[-y_closing, x_closing, 0.0], [x_closing, y_closing, 0.0], [0.0, 0.0, -1.0]]
    )
    return SE3(rotation, np.array([x, y, z]))


def disc(centre: Array, radius: float, count: int) -> Array:
    """(count, 3) points spread evenly over a level disc, in a spiral (Vogel, 1979)."""
    n = np.arange(count) + 0.5
    r, turn = radius * np.sqrt(n / count), n * np.pi * (3.0 - np.sqrt(5.0))
    flat: Array = np.stack([r * np.cos(turn), r * np.sin(turn), np.zeros(count)], axis=1)
    return flat + centre
