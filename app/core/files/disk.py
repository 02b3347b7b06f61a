"""Growing files of a run, written by a thread beside the loop.

Every file is valid at every moment, so that a killed process loses only the last half second. An
array is an ordinary `.npy` file: rows are appended first, then the number of rows is updated in the
header, where it has a field of fixed width.
"""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Callable, Sequence
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from numpy.lib.format import dtype_to_descr, write_array_header_1_0

from app.live import Feed
from config import UserError, counted

_PERIOD = 0.5  # interval between writes [s of real time]
_CAPACITY = 20_000
"""Most pieces that wait for a slow disk: more than half a minute of a run in real time."""
_BATCH = 2_000
PATIENCE = 30.0  # time for the disk to write the rest at the end [s]

Encode: TypeAlias = Callable[[Sequence[Any]], bytes]  # pieces as bytes, on the thread that writes


class Disk:
    """Writes the growing files of one run; an error ends only the file in which it happened.

    When the disk is slow, `lossless` lets `GrowingFile.add` wait (a simulation at full speed), or
    else the oldest of the `capacity` pieces that wait are dropped (in real time).
    """

    def __init__(self, folder: Path, *, lossless: bool, capacity: int = _CAPACITY) -> None:
        self._folder = folder
        self._files: list[GrowingFile] = []
        self._feed: Feed[tuple[GrowingFile, Any]] = Feed(
            self._write,
            lossless=lossless,
            period=_PERIOD,
            capacity=capacity,
            batch=_BATCH,
            name="disk",
        )

    def file(self, name: str, encode: Encode = b"".join) -> GrowingFile:
        """A new file of the run; raises UserError if it cannot be written."""
        return self._added(GrowingFile(self._folder / name, self._feed, encode))

    def array(self, name: str, row: npt.DTypeLike, encode: Encode = b"".join) -> GrowingFile:
        """A new `.npy` file; its pieces are encoded as the bytes of rows of type `row`.

        Raises UserError: it cannot be written.
        """
        return self._added(GrowingFile(self._folder / name, self._feed, encode, np.dtype(row)))

    def _added(self, file: GrowingFile) -> GrowingFile:
        self._files.append(file)
        return file

    def close(self, patience: float = PATIENCE) -> list[str]:
        """Write the rest within a time [s] and close; returns what went wrong, a line each."""
        wrong = []
        if not self._feed.close(patience):
            return [f"the disk did not take the rest of the run within {patience:.0f} s"]
        if self._feed.dropped:
            wrong.append(f"the disk was too slow for {counted(self._feed.dropped, 'piece')}")
        if self._feed.error is not None:
            wrong.append(f"the disk got nothing more ({self._feed.error})")
        return [*wrong, *filter(None, [file.close() for file in self._files])]

    def _write(self, batch: Sequence[tuple[GrowingFile, Any]]) -> None:
        pieces: dict[GrowingFile, list[Any]] = defaultdict(list)
        for file, piece in batch:
            pieces[file].append(piece)
        for file, some in pieces.items():
            file.write(some)


class GrowingFile:
    """A file to which pieces are appended; with a type of rows, an array."""

    def __init__(
        self,
        path: Path,
        feed: Feed[tuple[GrowingFile, Any]],
        encode: Encode = b"".join,
        row: np.dtype[Any] | None = None,
    ) -> None:
        self._name, self._feed, self._encode = path.name, feed, encode
        self._row, self._count = row, 0
        self._error: Exception | None = None
        try:
            self._file = path.open("wb", buffering=0)
            if row is not None:
                self._write_all(_header(row, 0))
        except OSError as error:
            raise UserError(f"{path}: cannot be written ({error.strerror})") from error

    def add(self, piece: Any) -> None:
        """Queue a piece for the thread that writes; never raises."""
        self._feed.put((self, piece))

    def write(self, pieces: Sequence[Any]) -> None:
        """Append now; does nothing after an error."""
        if self._error is not None:
            return
        try:
            self._append(self._encode(pieces))
        except Exception as error:  # the run must go on, and so must the other files
            self._error = error

    def close(self) -> str:
        """Close the file; returns what went wrong with it, if anything."""
        removed = os.fstat(self._file.fileno()).st_nlink == 0
        with suppress(OSError):
            self._file.close()
        if self._error is not None:
            why = getattr(self._error, "strerror", None) or repr(self._error)
            return f"{self._name} ends early ({why})"
        return f"{self._name} was removed while it was written" if removed else ""

    def _append(self, data: bytes) -> None:
        self._write_all(data)
        if self._row is not None:
            self._count += len(data) // self._row.itemsize
            self._file.seek(0)
            self._write_all(_header(self._row, self._count))
            self._file.seek(0, os.SEEK_END)

    def _write_all(self, data: bytes) -> None:
        rest = memoryview(data)
        while rest:  # a nearly full disk writes a part
            rest = rest[self._file.write(rest) :]


def _header(row: np.dtype[Any], count: int) -> bytes:
    """The header of an array; NumPy reserves space for the count, so its length is constant."""
    buffer = BytesIO()
    shape = (count, *row.shape)
    description = {"descr": dtype_to_descr(row.base), "fortran_order": False, "shape": shape}
    write_array_header_1_0(buffer, description)
    return buffer.getvalue()
