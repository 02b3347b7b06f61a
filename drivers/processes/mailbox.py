"""Mailbox in shared memory: one process's newest record, stamped by the common `stopwatch`."""

import mmap
import os
import struct
import tempfile
from typing import Any

_NUMBER = struct.Struct("<Q")
_TRIES = 1000
PAGE = 1024  # of memory for one mailbox [bytes]


class Mailbox:
    """One record with one writer and one reader."""

    def __init__(self, memory: mmap.mmap, place: int, layout: struct.Struct) -> None:
        assert layout.size + 2 * _NUMBER.size <= PAGE
        self._memory, self._layout = memory, layout
        self._before = place * PAGE
        self._record = self._before + _NUMBER.size
        self._after = self._record + layout.size
        self._count = 0
        self._last: tuple[Any, ...] | None = None

    def put(self, *values: Any) -> None:
        """Replace the record."""
        self._count += 1
        _NUMBER.pack_into(self._memory, self._before, self._count)
        self._layout.pack_into(self._memory, self._record, *values)
        _NUMBER.pack_into(self._memory, self._after, self._count)

    def get(self) -> tuple[Any, ...] | None:
        """The newest whole record; None before the first."""
        memory = self._memory
        for _ in range(_TRIES):
            after = _NUMBER.unpack_from(memory, self._after)
            values = self._layout.unpack_from(memory, self._record)
            if after == _NUMBER.unpack_from(memory, self._before):
                if after[0]:
                    self._last = values
                break
        return self._last


def share_memory(count: int) -> int:
    """A file descriptor of memory for `count` mailboxes, to be inherited."""
    if hasattr(os, "memfd_create"):
        descriptor = os.memfd_create("mailboxes")
    else:
        with tempfile.TemporaryFile() as file:
            descriptor = os.dup(file.fileno())
    os.ftruncate(descriptor, count * PAGE)
    return descriptor


def open_memory(descriptor: int) -> mmap.mmap:
    """The memory behind a descriptor."""
    return mmap.mmap(descriptor, 0)
