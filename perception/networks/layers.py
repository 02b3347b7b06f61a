"""Layers of the networks in NumPy, on images (N, height, width, channels) in single precision.

A convolution is a product of matrices: what each output pixel sees, and the kernel. It is done in
blocks that stay in the processor's cache, and in memory that is used again: fresh memory would cost
as much time as half of the products.
"""

from collections.abc import Iterator
from itertools import product

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from config.arrays import Image

_BLOCK = 2**17  # numbers


class Convolution:
    """A convolution and the rectifier behind it; what it returns is valid until the next call.

    Args:
        kernel: (out, in, size, size)
        bias: (out,)
        stride: of the output, along rows and columns.
        padding: rows and columns of zeros around the image.
    """

    def __init__(self, kernel: Image, bias: Image, *, stride: int = 1, padding: int = 1) -> None:
        self._size, self._stride, self._padding = kernel.shape[2:], stride, padding
        self._matrix = np.ascontiguousarray(kernel.transpose(2, 3, 1, 0).reshape(-1, len(kernel)))
        self._bias = bias
        self.block = _BLOCK // len(self._matrix)  # output pixels that are computed together
        self._image: Image = np.empty(0, dtype=np.float32)
        self._seen, self._output = self._image, self._image
        self._some = np.empty((self.block, len(self._matrix)), dtype=np.float32)

    def __call__(self, image: Image) -> Image:
        """Its output for images."""
        seen = self.windows(image)
        count, height, width = seen.shape[:3]
        images, rows = max(1, self.block // (height * width)), max(1, self.block // width)
        if self._output.shape[:3] != seen.shape[:3]:
            self._output = np.empty((*seen.shape[:3], len(self._bias)), dtype=np.float32)
        for block in product(_blocks(count, images), _blocks(height, rows)):
            self.rectified(seen[block], self._output[block].reshape(-1, len(self._bias)))
        return self._output

    def windows(self, image: Image) -> Image:
        """(N, height, width, size, size, in) what each output pixel sees of images."""
        inner = slice(self._padding, -self._padding or None)
        count, height, width, channels = image.shape
        padded = count, height + 2 * self._padding, width + 2 * self._padding, channels
        if self._image.shape != padded:
            self._image = np.zeros(padded, dtype=np.float32)
            seen = sliding_window_view(self._image, self._size, axis=(1, 2))
            self._seen = seen[:, :: self._stride, :: self._stride].transpose(0, 1, 2, 4, 5, 3)
        self._image[:, inner, inner] = image
        return self._seen

    def rectified(self, seen: Image, output: Image) -> Image:
        """Compute the `output` (P, out) of pixels from what they see, at most `block`."""
        some = self._some[: len(output)]
        np.copyto(some.reshape(seen.shape), seen)
        np.matmul(some, self._matrix, out=output)
        return np.maximum(np.add(output, self._bias, out=output), 0.0, out=output)


def _blocks(count: int, size: int) -> Iterator[slice]:
    return (slice(start, start + size) for start in range(0, count, size))


def pixel_shuffle(image: Image, factor: int) -> Image:
    """Images larger by a factor, whose channels were (factor, factor, out) (Shi et al., 2016)."""
    count, height, width, channels = image.shape
    parts = image.reshape(count, height, width, factor, factor, -1).transpose(0, 1, 3, 2, 4, 5)
    return parts.reshape(count, height * factor, width * factor, channels // factor**2)


def max_pool(image: Image) -> Image:
    """The largest of every 2x2 pixels."""
    rows = np.maximum(image[:, ::2], image[:, 1::2])
    return np.maximum(rows[:, :, ::2], rows[:, :, 1::2])
