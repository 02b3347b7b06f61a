"""Lock-free ring buffer of the newest images in memory that two processes share.

The writer fills the pages in turn and stores the number of the newest one last. A reader that is
overtaken while it copies sees that by the number on the page, and takes the newer one.
"""

import struct
from dataclasses import dataclass
from mmap import mmap

import numpy as np
import numpy.typing as npt

_NEWEST = struct.Struct("<Q")
"""Number of the newest image. `struct` clears before it writes, so where another process may look
at any moment it is stored at once (through numpy)."""
_PAGE = struct.Struct("<QQdd")  # number of the image, frames, stamp and arrival [s]
_PAGES = 3
_TRIES = 10

Depth = npt.NDArray[np.float32]
Grey = npt.NDArray[np.uint8]


@dataclass(frozen=True, kw_only=True, eq=False)
class BufferedImage:
    """One image; times are those of `stopwatch`, which all processes of a computer share."""

    number: int  # counted by the driver, from 1
    frames: int  # counted by the camera, from 1; the difference to `number` was lost
    stamp: float  # capture time [s]
    arrived: float  # when the driver received it [s]
    depth: Depth  # (H, W) depth along the optical axis [m]; NaN where missing
    infrared: Grey | None  # (H, W) image of the left imager; None if it is switched off


class ImageBuffer:
    """Images of one size in shared memory; one process puts, others get."""

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
        """Add an image; see `BufferedImage`."""
        self._count += 1
        at = self._page(self._count)
        _NEWEST.pack_into(self._memory, at, 0)  # marks the page as incomplete
        pixels = at + _PAGE.size
        self._depth(pixels)[...] = depth
        if infrared is not None:
            self._grey(pixels)[...] = infrared
        _PAGE.pack_into(self._memory, at, self._count, frames, stamp, arrived)
        self._newest[0] = self._count

    def arrival(self) -> float | None:
        """When the newest image arrived [s]; None before the first."""
        for _ in range(_TRIES):
            newest = self.newest_number()
            if newest == 0:
                return None
            number, _, _, arrived = _PAGE.unpack_from(self._memory, self._page(newest))
            if number == newest:
                return float(arrived)
        return None

    def newest_number(self) -> int:
        """Number of the newest image; 0 before the first."""
        return int(self._newest[0])

    def get(self, *, infrared: bool) -> BufferedImage | None:
        """A copy of the newest image; None before the first."""
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
                return BufferedImage(
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
        page = _PAGE.size + 5 * width * height
        return self._offset + _NEWEST.size + number % _PAGES * page

    def _depth(self, at: int) -> Depth:
        height, width = self._shape
        pixels = np.frombuffer(self._memory, np.float32, height * width, at)
        return pixels.reshape(self._shape)

    def _grey(self, at: int) -> Grey:
        height, width = self._shape
        pixels = np.frombuffer(self._memory, np.uint8, height * width, at + 4 * height * width)
        return pixels.reshape(self._shape)
