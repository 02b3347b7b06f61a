"""The newest images in memory that two processes share."""

import struct
from dataclasses import dataclass
from mmap import mmap

import numpy as np
import numpy.typing as npt

from config.arrays import Image
from drivers.processes.ring import Ring

_HEAD = struct.Struct("<Qd")  # frames, stamp [s]
_PAGES = 3
_TRIES = 10

Grey = npt.NDArray[np.uint8]


@dataclass(frozen=True, kw_only=True, eq=False)
class BufferedImage:
    """One image; times are those of `stopwatch`, which all processes of a computer share."""

    number: int  # counted by the driver, from 1
    frames: int  # counted by the camera, from 1; the difference to `number` was lost
    stamp: float  # capture time [s]
    arrived: float  # when the driver received it [s]
    depth: Image  # (H, W) depth along the optical axis [m]; NaN where missing
    infrared: Grey | None  # (H, W) image of the left imager; None if it is switched off


class ImageBuffer:
    """Images of one size in shared memory; one process puts, others get."""

    def __init__(self, memory: mmap, offset: int, width: int, height: int) -> None:
        self._shape = (height, width)
        self._ring = Ring(memory, offset, _PAGES, _HEAD.size + 5 * width * height)
        self.newest_number = self._ring.newest
        self.arrival = self._ring.arrival

    @staticmethod
    def size(width: int, height: int) -> int:
        """Bytes of memory for images of that size."""
        return Ring.needs(_PAGES, _HEAD.size + 5 * width * height)

    def put(
        self, frames: int, stamp: float, arrived: float, depth: Image, infrared: Grey | None
    ) -> None:
        """Add an image; see `BufferedImage`."""
        pixels = np.ascontiguousarray(np.broadcast_to(depth, self._shape)).view(np.uint8).ravel()
        grey = b"" if infrared is None else infrared.tobytes()
        self._ring.put(arrived, _HEAD.pack(frames, stamp), pixels, grey)

    def get(self, *, infrared: bool) -> BufferedImage | None:
        """A copy of the newest image; None before the first."""
        pixels = self._shape[0] * self._shape[1]
        for _ in range(_TRIES):
            newest = self._ring.newest()
            if newest and (message := self._ring.get(newest)) is not None:
                arrived, data = message
                frames, stamp = _HEAD.unpack_from(data)
                depth = np.frombuffer(data, np.float32, pixels, _HEAD.size)
                grey = np.frombuffer(data, np.uint8, -1, _HEAD.size + 4 * pixels)
                return BufferedImage(
                    number=newest,
                    frames=frames,
                    stamp=stamp,
                    arrived=arrived,
                    depth=depth.reshape(self._shape),
                    infrared=grey.reshape(self._shape) if infrared and grey.size else None,
                )
        return None
