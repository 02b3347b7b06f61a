"""From a depth image to what the network sees: a square of constant scale, without holes.

The network knows no scale: its widths are in pixels and its depth has lost its mean. So the square
is cut such that one network pixel always covers the same length at the depth of what the objects
stand on, as far as the image is large enough.

A stereo camera misses mainly what lies in the shadow of a nearer surface beside it. What is hidden
there is the background, so a hole takes the farther of its two neighbours in the row.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from perception.arrays import Array, Image, Mask
from perception.frame import Intrinsics
from perception.maps import SIZE

METRES_PER_PIXEL = 0.0015
"""Length that one network pixel covers at the depth of what the objects stand on [m]."""


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
    missing: Mask
    """(300, 300) where that depth was filled in."""
    native: Image
    """(size, size) depth without holes at the camera's own resolution [m]."""

    @property
    def network_input(self) -> Image:
        """(300, 300) depth less its mean, clipped to [-1, 1] [m], as published."""
        clipped: Image = np.clip(self.depth - self.depth.mean(), -1.0, 1.0)
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


def prepare(depth: Image, square: Square) -> Prepared:
    """Cut a square out, fill its holes and bring it to the network's size.

    Args:
        depth: (H, W) depth [m]; NaN, infinite or not above 0 where missing.
        square: which part of it.

    Raises:
        ValueError: the square holds no depth at all.
    """
    part = depth[square.v0 : square.v0 + square.size, square.u0 : square.u0 + square.size]
    missing = ~(np.isfinite(part) & (part > 0.0))
    native = fill(part, missing)
    interpolation = cv2.INTER_AREA if square.size > SIZE else cv2.INTER_LINEAR
    return Prepared(
        square=square,
        depth=np.asarray(
            cv2.resize(native, (SIZE, SIZE), interpolation=interpolation), dtype=np.float32
        ),
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
        ValueError: everything is missing.
    """
    if missing.all():
        raise ValueError("a depth image without any depth cannot be filled")
    filled = np.where(missing, np.float32(-np.inf), depth).astype(np.float32)
    if missing.any():
        filled = np.maximum(_from_left(filled, missing), _from_right(filled, missing))
        empty: Mask = np.asarray(missing.all(axis=1))
        if empty.any():
            rows = np.flatnonzero(~empty)
            nearest = np.abs(np.arange(len(empty))[:, None] - rows[None, :]).argmin(axis=1)
            filled = filled[rows[nearest]]
    return filled


def _from_left(values: Image, missing: Mask) -> Image:
    """Missing values replaced by the last one to their left; unchanged if there is none."""
    source = np.where(missing, 0, np.arange(values.shape[1], dtype=np.intp)[None, :])
    np.maximum.accumulate(source, axis=1, out=source)
    return np.take_along_axis(values, source, axis=1)


def _from_right(values: Image, missing: Mask) -> Image:
    return _from_left(values[:, ::-1], missing[:, ::-1])[:, ::-1]
