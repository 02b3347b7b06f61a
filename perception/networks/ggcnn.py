"""GG-CNN: grasp quality, angle and width for every third pixel of a depth image.

The network is the published one (Morrison, Corke and Leitner, "Closing the Loop for Robotic
Grasping", RSS 2018). Nearly all its work is in the last of its transposed convolutions. Each of
them equals a 3x3 convolution followed by a pixel shuffle, and the last of those is evaluated only
for the middle of every cell of 3x3 pixels, where candidates are sought.
"""

from pathlib import Path

import cv2
import numpy as np

from config.arrays import Image, Indices, Mask
from perception.grasps.candidates import Proposals
from perception.grasps.network_input import OUTPUT_STRIDE, WeightsError
from perception.networks.layers import Convolution, pixel_shuffle
from perception.networks.output_maps import REACH, find_candidates, grasp_maps
from perception.networks.weights import SHIPPED, Weights, read_weights

_HEADS = ("pos_output", "cos_output", "sin_output", "width_output")
_MIDDLE = slice(OUTPUT_STRIDE // 2, None, OUTPUT_STRIDE)  # of the cells [input px]
_LARGEST_OUTPUT = 1e6  # on a plain image; trained networks answer about 1


class GGCNN:
    """The published network for inference, with weights by their published names."""

    name = "ggcnn"

    def __init__(self, weights: Weights) -> None:
        def layer(name: str) -> tuple[Image, Image]:
            return weights[f"{name}.weight"], weights[f"{name}.bias"]

        self._down = (
            Convolution(*layer("conv1"), stride=3, padding=3),
            Convolution(*layer("conv2"), stride=2, padding=2),
            Convolution(*layer("conv3"), stride=2, padding=1),
        )
        self._up = tuple(
            Convolution(*_flat(*_subpixel(*layer(name), stride=2, padding=padding)))
            for name, padding in (("convt1", 1), ("convt2", 2))
        )
        kernel, bias = _subpixel(*layer("convt3"), stride=3, padding=3)
        # The heads see 2x2 pixels, those of phase 1 and 2 along each axis.
        self._last = Convolution(*_flat(kernel[1:, 1:], bias[1:, 1:]))
        heads, self._bias = (np.concatenate(each) for each in zip(*map(layer, _HEADS), strict=True))
        self._head = heads.transpose(2, 3, 1, 0).reshape(-1, len(_HEADS))

    def propose(self, image: Image, allowed: Mask) -> Proposals:
        """See `CandidateSource`."""
        allowed = allowed[_MIDDLE, _MIDDLE]
        wanted = cv2.dilate(allowed.astype(np.uint8), np.ones((2 * REACH + 1, 2 * REACH + 1)))
        maps = grasp_maps(self.infer(image, wanted > 0), allowed)
        return Proposals(find_candidates(maps), maps.quality_in_input())

    def infer(self, image: Image, wanted: Mask | None = None) -> Image:
        """Output in the cells of an image.

        Args:
            image: (3 n, 3 n) depth less its mean, clipped to [-1, 1] [m]; n is divisible by 4.
            wanted: (n, n) the cells that count; others may be 0.

        Returns:
            (4, n, n) quality, cosine and sine of twice the closing direction, width / 150 px. The
            direction is measured from the right, anticlockwise as seen (against that of v).
        """
        maps = image[None, :, :, None]
        for layer in self._down:
            maps = layer(maps)
        for layer in self._up:
            maps = pixel_shuffle(layer(maps), 2)
        seen = self._last.windows(maps)[0]
        rows, columns = np.nonzero(np.ones(seen.shape[:2]) if wanted is None else wanted)
        found = np.zeros((*seen.shape[:2], len(_HEADS)), dtype=np.float32)
        memory = np.empty((self._last.block, len(self._head)), dtype=np.float32)
        for start in range(0, len(rows), self._last.block):
            at = rows[start : start + self._last.block], columns[start : start + self._last.block]
            output = self._last.rectified(seen[at], memory[: len(at[0])])
            found[at] = output @ self._head + self._bias
        return np.ascontiguousarray(found.transpose(2, 0, 1))


def load_ggcnn(path: Path | None = None) -> GGCNN:
    """GG-CNN with the weights of a file; None is with the shipped ones.

    Raises:
        WeightsError: the file is missing, unreadable, of another network, or holds implausible
            numbers.
    """
    path = path or SHIPPED / "ggcnn.safetensors"
    network = GGCNN(read_weights(path, "ggcnn"))
    slope = np.linspace(-0.3, 0.3, 60, dtype=np.float32)
    with np.errstate(all="ignore"):
        answer = network.infer(np.add.outer(slope, slope))
    if not bool((np.abs(answer) < _LARGEST_OUTPUT).all()):
        raise WeightsError(f"{path}: the network answers implausible numbers; train it again")
    return network


def subpixel_taps(size: int, *, stride: int, padding: int) -> Indices:
    """(stride, 3) taps of the kernels by which a transposed convolution is a convolution.

    Output s q + r of a transposed convolution with stride s and padding p sums input q + o times
    tap r + p - s o, which is a tap of the kernel for o in (-1, 0, 1) alone: one 3-tap kernel for
    each of the s phases r. Where there is no tap it is `size`, that of a zero behind them.
    """
    taps = np.arange(stride)[:, None] + padding - stride * np.arange(-1, 2)
    return np.where((taps >= 0) & (taps < size), taps, size)


def _subpixel(kernel: Image, bias: Image, *, stride: int, padding: int) -> tuple[Image, Image]:
    """(s, s, out, in, 3, 3) kernels and (s, s, out) bias of the phases of (in, out, size, size)."""
    tap = subpixel_taps(kernel.shape[2], stride=stride, padding=padding)
    kernel = np.pad(kernel, ((0, 0), (0, 0), (0, 1), (0, 1)))
    kernel = kernel[:, :, tap[:, None, :, None], tap[None, :, None, :]]  # (in, out, s, s, 3, 3)
    return kernel.transpose(2, 3, 1, 0, 4, 5), np.tile(bias, (stride, stride, 1))


def _flat(kernel: Image, bias: Image) -> tuple[Image, Image]:
    """Kernel and bias of all phases as the channels of one convolution."""
    return kernel.reshape(-1, *kernel.shape[3:]), bias.ravel()
