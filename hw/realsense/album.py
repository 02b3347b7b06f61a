"""The newest images of the camera's process, for another that never waits for it.

Both processes share the memory. The writer goes from page to page and says last which is the
newest; a reader that is overtaken while it copies sees that by the number on the page, and takes
the newer one.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from mmap import mmap

import numpy as np
import numpy.typing as npt

_NEWEST = struct.Struct("<Q")
"""Number of the newest image. `struct` clears before it writes, so where another process may look
at any moment it is stored at once."""
_PAGE = struct.Struct("<QQdd")
"""Number of the image here, frames that the camera has numbered, stamp and arrival [s]."""
_PAGES = 3
_TRIES = 10

Depth = npt.NDArray[np.float32]
Grey = npt.NDArray[np.uint8]


@dataclass(frozen=True, kw_only=True, eq=False)
class Picture:
    """One image of a camera, on the clock of the computer, which all its processes share."""

    number: int
    """Counted by the driver, from 1."""
    frames: int
    """How many images the camera has taken since the first one; more than `number`: some are
    lost."""
    stamp: float
    """When it was captured, of `stopwatch` [s]."""
    arrived: float
    """When the driver was given it, of `stopwatch` [s]."""
    depth: Depth
    """(H, W) depth along the optical axis [m]; NaN where missing."""
    infrared: Grey | None
    """(H, W) image of the left imager; None if it is not switched on."""


class Album:
    """Images of one size in shared memory; one process puts, others get.

    Args:
        memory: that they share.
        offset: of the album in it [bytes].
        width: of the images.
        height: of the images.
    """

    def __init__(self, memory: mmap, offset: int, width: int, height: int) -> None:
        self._memory, self._offset = memory, offset
        self._shape = (height, width)
        self._newest = np.frombuffer(memory, np.uint64, 1, offset)
        self._count = 0

    @staticmethod
    def size(width: int, height: int) -> int:
        """Bytes of memory for images of that size."""
        return _NEWEST.size + _PAGES * (_PAGE.size + 5 * width * height)

    def put(
        self, frames: int, stamp: float, arrived: float, depth: Depth, infrared: Grey | None
    ) -> None:
        """Add an image; see `Picture`."""
        self._count += 1
        at = self._page(self._count)
        _NEWEST.pack_into(self._memory, at, 0)  # nothing whole is here now
        pixels = at + _PAGE.size
        self._depth(pixels)[...] = depth
        if infrared is not None:
            self._grey(pixels)[...] = infrared
        _PAGE.pack_into(self._memory, at, self._count, frames, stamp, arrived)
        self._newest[0] = self._count

    def arrival(self) -> float | None:
        """When the newest image arrived, of `stopwatch` [s]; None before the first."""
        for _ in range(_TRIES):
            newest = self.newest_number()
            if newest == 0:
                return None
            number, _, _, arrived = _PAGE.unpack_from(self._memory, self._page(newest))
            if number == newest:
                return float(arrived)
        return None

    def newest_number(self) -> int:
        """Of the newest image; 0 before the first."""
        return int(self._newest[0])

    def get(self, *, infrared: bool) -> Picture | None:
        """A copy of the newest image; None before the first.

        Args:
            infrared: whether there is such an image.
        """
        for _ in range(_TRIES):
            newest = self.newest_number()
            if newest == 0:
                return None
            at = self._page(newest)
            number, frames, stamp, arrived = _PAGE.unpack_from(self._memory, at)
            pixels = at + _PAGE.size
            depth = self._depth(pixels).copy()
            grey = self._grey(pixels).copy() if infrared else None
            (after,) = _NEWEST.unpack_from(self._memory, at)
            if number == newest == after:
                return Picture(
                    number=newest,
                    frames=frames,
                    stamp=stamp,
                    arrived=arrived,
                    depth=depth,
                    infrared=grey,
                )
        return None

    def _page(self, number: int) -> int:
        height, width = self._shape
        place = number % _PAGES
        return self._offset + _NEWEST.size + place * (_PAGE.size + 5 * width * height)

    def _depth(self, at: int) -> Depth:
        height, width = self._shape
        pixels = np.frombuffer(self._memory, np.float32, height * width, at)
        return pixels.reshape(self._shape)

    def _grey(self, at: int) -> Grey:
        height, width = self._shape
        pixels = np.frombuffer(self._memory, np.uint8, height * width, at + 4 * height * width)
        return pixels.reshape(self._shape)
