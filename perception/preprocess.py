"""From a depth image to what the network sees: a square of constant scale, level and without holes.

The network knows no scale: its widths are in pixels and its depth has lost its mean. So the square
is cut such that one network pixel always covers the same length at the depth of what the objects
stand on, as far as the image is large enough. Nor does it know how the camera is tilted: depth is
replaced by how far below the camera a pixel lies, which is the depth if the camera looks straight
down.

A stereo camera misses mainly what lies in the shadow of a nearer surface beside it. What is hidden
there is the background, so a hole takes the farther of its two neighbours in the row.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from pinocchio import SE3

from perception.arrays import Array, Image, Mask
from perception.frame import Intrinsics
from perception.geometry import world_maps
from perception.maps import SIZE

METRES_PER_PIXEL = 0.0015
"""Length that one network pixel covers at the depth of what the objects stand on [m]."""
FARTHEST = 5.0
"""Farther is not believed [m]."""


class NoDepthError(ValueError):
    """There is not a single depth to go by."""


def measured(depth: Image) -> Mask:
    """Where a depth image [m] holds something to be believed; not where it is not a number."""
    believed: Mask = (depth > 0.0) & (depth < FARTHEST)
    return believed


@dataclass(frozen=True, kw_only=True)
class Square:
    """A square of the full image."""

    u0: int
    """Left column [px]."""
    v0: int
    """Top row [px]."""
    size: int
    """Side [px]."""

    @property
    def scale(self) -> float:
        """Pixels of the full image to a network pixel."""
        return self.size / SIZE

    def to_image(self, pixel: Array) -> Array:
        """Full-image (u, v) of network pixels (u, v), whatever their leading shape."""
        image: Array = (pixel + 0.5) * self.scale - 0.5 + np.array([self.u0, self.v0])
        return image

    def to_network(self, pixel: Array) -> Array:
        """Network (u, v) of full-image pixels (u, v), whatever their leading shape."""
        network: Array = (pixel - np.array([self.u0, self.v0]) + 0.5) / self.scale - 0.5
        return network


@dataclass(frozen=True, kw_only=True, eq=False)
class Prepared:
    """A square of a depth image, ready for the network."""

    square: Square
    depth: Image
    """(300, 300) depth without holes [m]."""
    below: Image
    """(300, 300) how far below the camera that is [m]."""
    missing: Mask
    """(300, 300) where that depth was filled in."""
    native: Image
    """(size, size) depth without holes at the camera's own resolution [m]."""

    @property
    def network_input(self) -> Image:
        """(300, 300) level depth less its mean, clipped to [-1, 1] [m]."""
        clipped: Image = np.clip(self.below - self.below.mean(), -1.0, 1.0)
        return clipped


def central_square(shape: tuple[int, int], intrinsics: Intrinsics, depth: float) -> Square:
    """The square about the image's centre with the network's scale at a depth.

    Args:
        shape: (H, W) of the image.
        intrinsics: the camera's pinhole model.
        depth: distance along the optical axis of what the objects stand on [m].
    """
    height, width = shape
    wanted = SIZE * METRES_PER_PIXEL * intrinsics.fx / max(depth, 1e-3)
    size = int(np.clip(round(wanted), min(SIZE // 2, height, width), min(height, width)))
    return Square(u0=(width - size) // 2, v0=(height - size) // 2, size=size)


def prepare(depth: Image, square: Square, intrinsics: Intrinsics, wTc: SE3) -> Prepared:
    """Cut a square out, fill its holes, bring it to the network's size and level it.

    Args:
        depth: (H, W) depth [m]; what is not `measured` is missing.
        square: which part of it.
        intrinsics: the camera's pinhole model.
        wTc: camera in the world.

    Raises:
        NoDepthError: the square holds no depth at all.
    """
    part = depth[square.v0 : square.v0 + square.size, square.u0 : square.u0 + square.size]
    missing = ~measured(part)
    native = fill(part, missing)
    interpolation = cv2.INTER_AREA if square.size > SIZE else cv2.INTER_LINEAR
    resized: Image = np.asarray(
        cv2.resize(native, (SIZE, SIZE), interpolation=interpolation), dtype=np.float32
    )
    pixels = np.arange(SIZE, dtype=float)
    u, v = square.to_image(np.stack([pixels, pixels], axis=1)).T
    camera = SE3(wTc.rotation, np.zeros(3))
    (up,) = world_maps(resized, intrinsics, camera, u[None, :], v[:, None], axes=(2,))
    return Prepared(
        square=square,
        depth=resized,
        below=-up,
        missing=cv2.resize(
            missing.astype(np.uint8), (SIZE, SIZE), interpolation=cv2.INTER_NEAREST
        ).astype(np.bool_),
        native=native,
    )


def fill(depth: Image, missing: Mask) -> Image:
    """Give each missing pixel the larger value of its nearest neighbours left and right.

    Args:
        depth: (H, W).
        missing: (H, W) where `depth` means nothing.

    Returns:
        A copy without holes. A row without any value takes those of the nearest row that has some.

    Raises:
        NoDepthError: everything is missing.
    """
    if missing.all():
        raise NoDepthError("a depth image without any depth cannot be filled")
    filled: Image = np.array(depth, dtype=np.float32)
    pixel = np.flatnonzero(missing)
    if len(pixel) == 0:
        return filled
    width = depth.shape[1]
    follows = (np.diff(pixel) == 1) & (pixel[1:] % width != 0)
    begin = np.flatnonzero(np.concatenate([[True], ~follows]))  # of each hole in its row
    end = np.append(begin[1:], len(pixel))
    first, last = pixel[begin], pixel[end - 1]
    value = np.maximum(
        np.where(first % width > 0, filled.ravel()[first - 1], -np.inf),
        np.where((last + 1) % width > 0, filled.ravel()[(last + 1) % filled.size], -np.inf),
    )
    filled.ravel()[pixel] = np.repeat(value, end - begin)
    empty = np.asarray(missing.all(axis=1))
    if empty.any():
        rows = np.flatnonzero(~empty)
        nearest = np.abs(np.arange(len(empty))[:, None] - rows[None, :]).argmin(axis=1)
        filled = filled[rows[nearest]]
    return filled
