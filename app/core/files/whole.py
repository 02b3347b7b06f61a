"""What is whole of files that were cut, as by a full disk or a power cut."""

from collections.abc import Iterator
from contextlib import suppress
from math import prod
from pathlib import Path
from struct import Struct
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.lib.format import read_array_header_1_0, read_magic

from app.core.files.events import EVENTS
from app.core.files.folder import COMMANDS, NOTES, READINGS, RECORDING, STATES

_RERUN, _HEAD, _MESSAGE = b"RRF2", 12, Struct("<QQ")  # of a message: kind and length


def whole_rows(path: Path) -> tuple[npt.NDArray[Any], int]:
    """The whole rows of a `.npy` file, and how many were lost; ValueError: it is none of ours."""
    with path.open("rb") as file:
        if read_magic(file) != (1, 0):
            raise ValueError("another version of the format")
        shape, is_fortran, row = read_array_header_1_0(file)
        data = file.read()
    width = row.itemsize * prod(shape[1:])
    if row.hasobject or is_fortran or not shape or shape[0] < 0 or width <= 0:
        raise ValueError(f"{row} of shape {shape}")
    count = min(shape[0], len(data) // width)
    rows = np.frombuffer(data[: count * width], row).reshape(count, *shape[1:])
    return rows.copy(), shape[0] - count


def whole_size(recording: Path) -> int:
    """The bytes of a recording up to the end of its last whole message; all if it is none."""
    size, end = recording.stat().st_size, _HEAD
    with recording.open("rb") as file:
        if file.read(len(_RERUN)) != _RERUN:
            return size
        while end < size:
            file.seek(end)
            length = _MESSAGE.unpack(file.read(_MESSAGE.size).ljust(_MESSAGE.size, b"\xff"))[1]
            if end + _MESSAGE.size + length > size:
                break
            end += _MESSAGE.size + length
    return end


def losses(folder: Path) -> Iterator[str]:
    """What is cut off from the files of a run, a line each; the rest is used."""
    names = (STATES, COMMANDS, READINGS, NOTES, EVENTS, RECORDING)
    for path in filter(Path.is_file, (folder / name for name in names)):
        with suppress(ValueError, OSError):  # whoever reads it says so
            if path.suffix == ".npy" and (lost := whole_rows(path)[1]):
                yield f"{path}: the end is cut off: {lost} rows are missing"
            elif path.suffix == ".jsonl" and path.read_bytes()[-1:] not in (b"\n", b""):
                yield f"{path}: the last line is cut off, and left out"
            elif path.suffix == ".rrd" and (lost := path.stat().st_size - whole_size(path)):
                yield f"{path}: the last message is cut off ({lost} bytes), and left out"
