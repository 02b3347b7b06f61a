"""Input of the grasp networks: a crop of constant scale, levelled and filled.

A network cannot infer scale: its widths are in pixels and the mean depth is subtracted. One input
pixel therefore always covers the same length at the depth of the support surface, as far as the
image is large enough. Nor can it infer the camera's tilt: depth is replaced by the vertical
distance below the camera. A hole is mostly the stereo shadow of a nearer surface, so it takes the
farther of its two neighbours in the row.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from pinocchio import SE3

from config import UserError
from perception.frame import Array, Frame, Image, Indices, Mask
from perception.geometry import world_maps, world_points
from robots import Intrinsics

INPUT_SIZE = 300  # side of a network's input image [px]
OUTPUT_STRIDE = 3  # input pixels per cell of the labels and of the maps
GRID_SIZE = INPUT_SIZE // OUTPUT_STRIDE  # side of the grid of labels [cells]
ANGLE_BINS = 16  # closing directions: bin i is i π / 16, anticlockwise in the image
WIDTH_SCALE = 150.0  # a width map holds the opening divided by this, as published [input px]
METRES_PER_PIXEL = 0.0015  # length that an input pixel covers at the support surface [m]
MAX_DEPTH = 5.0  # larger readings are missing [m]


class WeightsError(UserError):
    """Weights are missing or do not fit the network."""


class NoDepthError(ValueError):
    """No pixel has a depth."""


def valid_depth(depth: Image) -> Mask:
    """Which pixels of a depth image [m] hold a usable depth; NaN is none."""
    valid: Mask = (depth > 0.0) & (depth < MAX_DEPTH)
    return valid


def measured(
    frame: Frame, every: int, row: int = 0, column: int = 0
) -> tuple[Indices, Indices, Array]:
    """Rows, columns [px] and (N, 3) points in the world [m] of the usable pixels of a part.

    The part is every n-th row and column, from the given ones on.
    """
    depth = np.asarray(frame.depth)[row::every, column::every]
    v, u = np.nonzero(valid_depth(depth))
    z, v, u = depth[v, u].astype(float), row + every * v, column + every * u
    points = world_points(z, frame.intrinsics, frame.wTc, u.astype(float), v.astype(float))
    return v, u, points


@dataclass(frozen=True, kw_only=True)
class Crop:
    """A square part of the full image."""

    u0: int  # left column [px]
    v0: int  # top row [px]
    size: int  # side [px]

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


def prepare(depth: Image, crop: Crop, intrinsics: Intrinsics, wTc: SE3) -> Prepared:
    """Crop an (H, W) depth image [m], fill its holes, resize and level it.

    Raises:
        NoDepthError: no pixel of the crop has a depth.
    """
    part = depth[crop.v0 : crop.v0 + crop.size, crop.u0 : crop.u0 + crop.size]
    missing = ~valid_depth(part)
    native = fill(part, missing)
    interpolation = cv2.INTER_AREA if crop.size > INPUT_SIZE else cv2.INTER_LINEAR
    resized: Image = np.asarray(
        cv2.resize(native, (INPUT_SIZE, INPUT_SIZE), interpolation=interpolation), dtype=np.float32
    )
    pixels = np.arange(INPUT_SIZE, dtype=float)
    u, v = crop.to_image(np.stack([pixels, pixels], axis=1)).T
    camera = SE3(wTc.rotation, np.zeros(3))
    (up,) = world_maps(resized, intrinsics, camera, u[None, :], v[:, None], axes=(2,))
    return Prepared(
        crop=crop,
        depth=resized,
        below=-up,
        missing=cv2.resize(
            missing.astype(np.uint8), (INPUT_SIZE, INPUT_SIZE), interpolation=cv2.INTER_NEAREST
        ).astype(np.bool_),
    )


def fill(depth: Image, missing: Mask) -> Image:
    """A copy whose missing pixels have the larger of their nearest neighbours left and right.

    A row without a value is copied from the nearest row with one.

    Raises:
        NoDepthError: all pixels are missing.
    """
    if missing.all():
        raise NoDepthError("no pixel of the depth image has a depth")
    filled: Image = np.array(depth, dtype=np.float32)
    first, last = holes(missing)
    if len(first) == 0:
        return filled
    width, values = depth.shape[1], filled.ravel()
    value = np.maximum(
        np.where(first % width > 0, values[first - 1], -np.inf),
        np.where((last + 1) % width > 0, values[(last + 1) % filled.size], -np.inf),
    )
    filled[missing] = np.repeat(value, last - first + 1)
    empty = np.asarray(missing.all(axis=1))
    if empty.any():
        blank, rows = np.flatnonzero(empty), np.flatnonzero(~empty)
        nearest = np.abs(blank[:, None] - rows).argmin(axis=1)
        filled[blank] = filled[rows[nearest]]
    return filled


def holes(missing: Mask) -> tuple[Indices, Indices]:
    """Flat numbers (N,) of the first and of the last pixel of each hole in a row, in order."""
    begins, ends = missing.copy(), missing.copy()
    np.greater(missing[:, 1:], missing[:, :-1], out=begins[:, 1:])
    np.greater(missing[:, :-1], missing[:, 1:], out=ends[:, :-1])
    return np.flatnonzero(begins), np.flatnonzero(ends)
