"""Noise of a stereo depth camera such as the RealSense D435.

Such a camera measures the disparity d = fx·baseline / z between two imagers, so the noise is added
there: the disparity has an error of a fraction of a pixel and comes in steps. Surfaces that only
one imager sees are missing, and so are depth edges, speckles, and what is too near or too far.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from robots import CameraDescription

DepthImage = npt.NDArray[np.float32]


@dataclass(frozen=True, kw_only=True)
class D435Noise:
    """Noise parameters; the defaults are those of a D435 at 640 x 480."""

    disparity_noise: float = 0.08  # standard deviation, equal in blocks of 2 x 2 [px]
    disparity_step: float = 1.0 / 32.0  # quantization of the disparity [px]
    edge_step: float = 0.02  # depth difference of neighbours at an edge [m]
    edge_loss: float = 0.7  # Probability that a pixel at an edge is lost
    speckle: float = 0.008  # Share of pixels lost in small patches

    def apply(
        self, depth: DepthImage, camera: CameraDescription, rng: np.random.Generator
    ) -> DepthImage:
        """A noisy copy of a depth image (H, W) [m], in whole millimetres; NaN where missing."""
        far = np.nan_to_num(depth, nan=1e3)
        scale = np.float32(camera.intrinsics.fx * camera.baseline)
        disparity: DepthImage = scale / far
        seen = (far >= camera.min_range) & (far <= camera.max_range)
        seen &= ~_hidden_from_the_other_imager(disparity)
        lost = _edges(far, self.edge_step) & (_uniform(rng, depth.shape, 1) < self.edge_loss)
        lost |= _uniform(rng, depth.shape, 4) < self.speckle
        seen &= ~lost
        disparity += np.float32(self.disparity_noise) * _normal(rng, depth.shape, 2)
        step = np.float32(self.disparity_step)
        disparity = np.maximum(np.rint(disparity / step), np.float32(1.0)) * step
        millimetres = np.rint(scale / disparity * np.float32(1000.0))
        return np.where(seen, millimetres / np.float32(1000.0), np.float32(np.nan))


def _hidden_from_the_other_imager(disparity: DepthImage) -> npt.NDArray[np.bool_]:
    """Pixels left of a nearer surface, which lands at or left of them in the right imager."""
    column = np.arange(disparity.shape[1], dtype=np.float32) - disparity
    leftmost = np.minimum.accumulate(column[:, ::-1], axis=1)[:, ::-1]
    hidden = np.zeros(disparity.shape, dtype=np.bool_)
    hidden[:, :-1] = leftmost[:, 1:] <= column[:, :-1]
    return hidden


def _edges(depth: DepthImage, step: float) -> npt.NDArray[np.bool_]:
    """Pixels on either side of a jump in depth of more than `step` [m]."""
    edges = np.zeros(depth.shape, dtype=np.bool_)
    jump = np.abs(np.diff(depth, axis=1)) > step
    edges[:, 1:] |= jump
    edges[:, :-1] |= jump
    jump = np.abs(np.diff(depth, axis=0)) > step
    edges[1:] |= jump
    edges[:-1] |= jump
    return edges


def _uniform(rng: np.random.Generator, shape: tuple[int, ...], block: int) -> DepthImage:
    """(H, W) uniform numbers in [0, 1), equal within square blocks."""
    return _spread(rng.random(_blocks(shape, block), dtype=np.float32), shape, block)


def _normal(rng: np.random.Generator, shape: tuple[int, ...], block: int) -> DepthImage:
    """(H, W) standard normal numbers, equal within square blocks."""
    return _spread(rng.standard_normal(_blocks(shape, block), dtype=np.float32), shape, block)


def _blocks(shape: tuple[int, ...], block: int) -> tuple[int, int]:
    return -(-shape[0] // block), -(-shape[1] // block)


def _spread(values: DepthImage, shape: tuple[int, ...], block: int) -> DepthImage:
    if block == 1:
        return values
    return np.repeat(np.repeat(values, block, 0), block, 1)[: shape[0], : shape[1]]
