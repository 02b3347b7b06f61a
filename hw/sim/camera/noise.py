"""Noise of a stereo depth camera such as the RealSense D435.

Such a camera measures the disparity d = fx·baseline / z between two imagers, so the noise is added
there: the disparity has an error of a fraction of a pixel and comes in steps. Surfaces that only
one imager sees are missing, and so are depth edges, speckles, and what is too near or too far.
"""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from config.arrays import Image, Mask
from robots import CameraDescription

Value = TypeVar("Value", bound=np.generic)

_FARTHEST = np.float32(1e3)  # what is farther, or not there, counts as this far [m]


@dataclass(frozen=True, kw_only=True)
class D435Noise:
    """Noise parameters; the defaults are those of a D435 at 640 x 480."""

    disparity_noise: float = 0.08  # standard deviation, equal in blocks of 2 x 2 [px]
    disparity_step: float = 1.0 / 32.0  # quantization of the disparity [px]
    edge_step: float = 0.02  # depth difference of neighbours at an edge [m]
    edge_loss: float = 0.7  # Probability that a pixel at an edge is lost
    speckle: float = 0.008  # Share of pixels lost in small patches

    def apply(self, depth: Image, camera: CameraDescription, rng: np.random.Generator) -> Image:
        """A noisy copy of a depth image (H, W) [m], in whole millimetres; NaN where missing."""
        # With a number in place of an array, fmin is several times slower, and so is maximum.
        far: Image = np.fmin(depth, np.full_like(depth, _FARTHEST))
        scale, step = np.float32(camera.intrinsics.fx * camera.baseline), self.disparity_step
        values: Image = scale / far  # disparities [px], later millimetres
        seen = (far >= camera.min_range) & (far <= camera.max_range)
        seen &= ~_hidden_from_the_other_imager(values)
        lost = _edges(far, self.edge_step)
        lost &= rng.random(far.shape, dtype=np.float32) < self.edge_loss
        lost |= _spread(rng.random(_blocks(far.shape, 4), dtype=np.float32) < self.speckle, far, 4)
        seen &= ~lost
        noise = rng.standard_normal(_blocks(far.shape, 2), dtype=np.float32)
        values += _spread(np.float32(self.disparity_noise) * noise, far, 2)
        values /= step
        np.clip(np.rint(values, out=values), 1.0, np.inf, out=values)
        values *= step
        np.divide(scale, values, out=values)
        values *= 1000.0
        np.rint(values, out=values)
        values /= 1000.0
        np.copyto(values, np.nan, where=~seen)
        return values


def _hidden_from_the_other_imager(disparity: Image) -> Mask:
    """Pixels left of a nearer surface, which lands at or left of them in the right imager."""
    column = np.arange(disparity.shape[1], dtype=np.float32) - disparity
    hidden = np.zeros(disparity.shape, dtype=np.bool_)
    nearer = column[:, 1:] <= column[:, :-1]
    rows, ends = (np.flatnonzero(nearer.any(axis=axis)) for axis in (1, 0))
    if rows.size:  # nothing is hidden above, below and right of all steps to a nearer surface
        part = slice(rows[0], rows[-1] + 1), slice(ends[-1] + 1)
        right = column[part[0], 1 : ends[-1] + 2]
        leftmost = np.minimum.accumulate(right[:, ::-1], axis=1)[:, ::-1]
        hidden[part] = leftmost <= column[part]
    return hidden


def _edges(depth: Image, step: float) -> Mask:
    """Pixels on either side of a jump in depth of more than `step` [m]."""
    edges = np.zeros(depth.shape, dtype=np.bool_)
    for jumped, away in ((edges, depth), (edges.T, depth.T)):
        difference = away[1:] - away[:-1]
        jump = np.abs(difference, out=difference) > step
        jumped[1:] |= jump
        jumped[:-1] |= jump
    return edges


def _blocks(shape: tuple[int, ...], block: int) -> tuple[int, int]:
    """How many square blocks cover an image, along rows and columns."""
    return -(-shape[0] // block), -(-shape[1] // block)


def _spread(values: npt.NDArray[Value], like: Image, block: int) -> npt.NDArray[Value]:
    """Values of square blocks at each of their pixels."""
    return values.repeat(block, 1)[:, : like.shape[1]].repeat(block, 0)[: like.shape[0]]
