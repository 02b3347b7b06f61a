"""Input of the grasp networks: a crop of constant scale, levelled and filled.

A network cannot infer scale: its widths are in pixels and the mean depth is subtracted. One input
pixel therefore always covers the same length at the depth of the support surface, as far as the
image is large enough. Nor can it infer the camera's tilt: depth is replaced by the vertical
distance below the camera. A hole is mostly the stereo shadow of a nearer surface, so it takes the
farther of its two neighbours in the row.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from pinocchio import SE3

from config import UserError
from config.arrays import Array, Image, Indices, Mask
from perception.cloud import DepthCloud
from perception.geometry import world_maps
from robots import Intrinsics

INPUT_SIZE = 300  # side of a network's input image [px]
OUTPUT_STRIDE = 3  # input pixels per cell of the labels and of the maps
WIDTH_SCALE = 150.0  # a width map holds the opening divided by this, as published [input px]
GRID_SIZE = INPUT_SIZE // OUTPUT_STRIDE  # side of the grid of labels [cells]
ANGLE_BINS = 16  # closing directions: bin i is i π / 16, anticlockwise in the image
METRES_PER_PIXEL = 0.0015  # length that an input pixel covers at the support surface [m]


class WeightsError(UserError):
    """Weights are missing or do not fit the network."""


class NoDepthError(ValueError):
    """No pixel has a depth."""


@dataclass(frozen=True, kw_only=True)
class Crop:
    """A square part of the full image."""

    u0: int  # left column [px]
    v0: int  # top row [px]
    size: int  # side [px]

    @property
    def window(self) -> tuple[slice, slice]:
        """Its rows and columns in the full image."""
        return slice(self.v0, self.v0 + self.size), slice(self.u0, self.u0 + self.size)

    @property
    def scale(self) -> float:
        """Full-image pixels per input pixel."""
        return self.size / INPUT_SIZE

    def to_image(self, pixel: Array) -> Array:
        """Full-image (u, v) of input pixels (..., 2)."""
        image: Array = (pixel + 0.5) * self.scale - 0.5 + np.array([self.u0, self.v0])
        return image


@dataclass(frozen=True, kw_only=True, eq=False)
class Prepared:
    """A crop of a depth image, ready for the network."""

    crop: Crop
    depth: Image  # (300, 300) depth without holes [m]
    below: Image  # (300, 300) vertical distance below the camera [m]
    missing: Mask  # (300, 300) where `depth` was filled in

    @property
    def network_input(self) -> Image:
        """(300, 300) `below` less its mean, clipped to [-1, 1] [m]."""
        clipped: Image = np.clip(self.below - self.below.mean(), -1.0, 1.0)
        return clipped


def scaled_crop(
    shape: tuple[int, int], intrinsics: Intrinsics, depth: float, about: Array | None = None
) -> Crop:
    """The crop of an (H, W) image with the network's scale at a depth.

    `depth` is that of the support surface, along the optical axis [m]. The crop lies about a pixel
    (2,), as far as the image goes; None is the image centre.
    """
    height, width = shape
    wanted = INPUT_SIZE * METRES_PER_PIXEL * intrinsics.fx / max(depth, 1e-3)
    size = int(np.clip(round(wanted), min(INPUT_SIZE // 2, height, width), min(height, width)))
    if about is None:
        return Crop(u0=(width - size) // 2, v0=(height - size) // 2, size=size)
    u0, v0 = np.clip(np.rint(about - 0.5 * size), 0, [width - size, height - size]).astype(int)
    return Crop(u0=int(u0), v0=int(v0), size=size)


def prepare(cloud: DepthCloud, crop: Crop) -> Prepared:
    """Crop a depth image, fill its holes, resize and level it.

    Raises:
        NoDepthError: no pixel of the crop has a depth.
    """
    part = cloud.part(*crop.window)
    missing = ~part.valid
    size = INPUT_SIZE, INPUT_SIZE
    interpolation = cv2.INTER_AREA if crop.size > INPUT_SIZE else cv2.INTER_LINEAR
    resized = cv2.resize(fill(part.depth, missing), size, interpolation=interpolation)
    depth: Image = np.asarray(resized, dtype=np.float32)
    pixels = np.arange(INPUT_SIZE, dtype=float)
    u, v = crop.to_image(np.stack([pixels, pixels], axis=1)).T
    camera = SE3(cloud.oTc.rotation, np.zeros(3))
    (up,) = world_maps(depth, cloud.intrinsics, camera, u[None, :], v[:, None], axes=(2,))
    filled = cv2.resize(missing.view(np.uint8), size, interpolation=cv2.INTER_NEAREST)
    return Prepared(crop=crop, depth=depth, below=-up, missing=np.asarray(filled) > 0)


def fill(depth: Image, missing: Mask, gaps: Gaps | None = None) -> Image:
    """A copy whose missing pixels have the larger of their nearest neighbours left and right.

    A row without a value is copied from the nearest row with one. `gaps` are those of `missing`,
    where they are known.

    Raises:
        NoDepthError: all pixels are missing.
    """
    filled: Image = np.array(depth, dtype=np.float32)
    gaps = gaps_in(missing) if gaps is None else gaps
    if len(gaps.first) == 0:
        return filled
    if missing.all():
        raise NoDepthError("no pixel of the depth image has a depth")
    value = np.maximum(*gaps.beside(filled, -np.inf))
    filled[missing] = np.repeat(value, gaps.last - gaps.first + 1)
    empty = np.asarray(missing.all(axis=1))
    if empty.any():
        blank, rows = np.flatnonzero(empty), np.flatnonzero(~empty)
        nearest = np.abs(blank[:, None] - rows).argmin(axis=1)
        filled[blank] = filled[rows[nearest]]
    return filled


class Gaps(NamedTuple):
    """The gaps in the rows of an image, row by row."""

    first: Indices  # (N,) flat number of the first pixel of each
    last: Indices  # (N,) ... of the last

    def beside(self, values: Image, border: float) -> tuple[Image, Image]:
        """The values (N,) left and right of each gap; those beyond the border are given."""
        width, flat = values.shape[1], values.ravel()
        before, after = self.first - 1, self.last + 1
        return (
            np.where(self.first % width > 0, flat[before], border),
            np.where(after % width > 0, flat[after % flat.size], border),
        )


def gaps_in(missing: Mask) -> Gaps:
    """The gaps of an image, (H, W) which of its pixels are missing."""
    rows, width = missing.shape
    # Before the first row and after each there is one that is not missing: it ends every gap.
    flat = np.zeros(rows * (width + 1) + 1, dtype=np.bool_)
    flat[1:].reshape(rows, width + 1)[:, :-1] = missing
    turns = np.flatnonzero(flat[1:] != flat[:-1])
    first, last = turns[::2], turns[1::2] - 1
    return Gaps(first - first // (width + 1), last - last // (width + 1))
