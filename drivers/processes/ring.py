"""Ring of the last messages in memory that two processes share: one puts, the other gets.

The writer fills the slots in turn and stores the number of the newest one last. A reader that is
overtaken while it copies sees that by the number in the slot.
"""

import struct
from collections.abc import Iterator
from mmap import mmap
from typing import Any

import numpy as np

_NEWEST = struct.Struct("<Q")
"""Number of the newest message. `struct` clears before it writes, so where another process may
look at any moment it is stored at once (through numpy)."""
_SLOT = struct.Struct("<QdQ")  # number, arrival [s], length [bytes]


class Ring:
    """The last `slots` messages of up to `size` bytes; numbers count from 1."""

    def __init__(self, memory: mmap, offset: int, slots: int, size: int) -> None:
        self._memory, self._offset, self._slots, self._size = memory, offset, slots, size
        self._newest = np.frombuffer(memory, np.uint64, 1, offset)
        self._count = self.newest()  # a new writer goes on

    @staticmethod
    def needs(slots: int, size: int) -> int:
        """Bytes of memory."""
        return _NEWEST.size + slots * (_SLOT.size + size)

    def put(self, arrived: float, *parts: Any) -> None:
        """Append bytes that arrived at a time of `stopwatch` [s]; what is too long is dropped."""
        length = sum(map(len, parts))
        if length > self._size:
            return
        self._count += 1
        at = self._slot(self._count)
        _NEWEST.pack_into(self._memory, at, 0)  # marks the slot as incomplete
        place = at + _SLOT.size
        for part in parts:
            self._memory[place : place + len(part)] = memoryview(part)
            place += len(part)
        _SLOT.pack_into(self._memory, at, self._count, arrived, length)
        self._newest[0] = self._count

    def newest(self) -> int:
        """Number of the newest message; 0 before the first."""
        return int(self._newest[0])

    def since(self, number: int) -> Iterator[tuple[int, tuple[float, bytearray]]]:
        """Numbers, and what `get` gives, of the messages after one that are still there."""
        newest = self.newest()
        oldest = max(1, newest - self._slots + 2)  # the one before it is being overwritten
        for later in range(max(number + 1, oldest), newest + 1):
            if (one := self.get(later)) is not None:
                yield later, one

    def get(self, number: int) -> tuple[float, bytearray] | None:
        """When a message arrived [s], and a copy; None if it is not there any more."""
        at = self._slot(number)
        there, arrived, length = _SLOT.unpack_from(self._memory, at)
        begin = at + _SLOT.size
        with memoryview(self._memory) as memory:
            message = bytearray(memory[begin : begin + min(length, self._size)])
        (after,) = _NEWEST.unpack_from(self._memory, at)
        return (arrived, message) if there == number == after else None

    def arrival(self) -> float | None:
        """When the newest message arrived [s]; None before the first."""
        number = self.newest()
        there, arrived, _ = _SLOT.unpack_from(self._memory, self._slot(number))
        return float(arrived) if number and there == number else None

    def _slot(self, number: int) -> int:
        return self._offset + _NEWEST.size + number % self._slots * (_SLOT.size + self._size)
