"""Depth images from a recording, of this project or of any other that logs depth to Rerun."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from app.core import whole_size
from config import UserError
from config.arrays import Image

_ENCODED, _RAW = "EncodedDepthImage:", "DepthImage:"
_DTYPES: dict[int, str] = {6: "u1", 7: "u2", 8: "u4", 33: "f2", 34: "f4", 35: "f8"}
"""By the number of Rerun's channel type."""
_HINT = "; use a recording with depth images"
_Row = dict[str, Any]  # components of one row of a chunk by name, and its `time` [s]


class NoDepthError(UserError):
    """The recording has no readable depth image."""


class RecordedDepth(NamedTuple):
    """A recorded depth image."""

    depth: Image  # (H, W) [m]; 0 where missing
    focal: float | None  # focal length [px], if it was recorded


def recorded_depth(recording: Path, at: float | None) -> RecordedDepth:
    """The depth image nearest to a time in a recording.

    `at` is on the recording's first timeline that counts from its start [s]; None takes the last
    image. Raises NoDepthError: it is not a recording, or has no depth image.
    """
    focal: float | None = None
    best: tuple[float, _Row] | None = None
    with _reading(recording):
        for row in _rows(recording):
            if "Pinhole:image_from_camera" in row:
                focal = float(row["Pinhole:image_from_camera"][0][0])
            if _has_depth(row):
                distance = -row["time"] if at is None else abs(row["time"] - at)
                if best is None or distance <= best[0]:
                    best = distance, row
    if best is None:
        raise NoDepthError(f"{recording}: the recording has no depth images{_HINT}")
    try:
        depth = _decoded(best[1])
    except (LookupError, TypeError, ValueError) as error:
        raise NoDepthError(f"{recording}: its depth images are damaged ({error}){_HINT}") from error
    if depth is None:
        raise NoDepthError(f"{recording}: the encoding of its depth images is not supported{_HINT}")
    return RecordedDepth(depth, focal)


def depth_images(recording: Path) -> Iterator[tuple[float, Image]]:
    """All depth images of a recording: time [s], and (H, W) [m], 0 where missing.

    Raises NoDepthError: it is not a recording, or an image in it is damaged.
    """
    with _reading(recording):
        for row in filter(_has_depth, _rows(recording, "/world/camera/**")):
            depth = _decoded(row)
            if depth is not None:
                yield row["time"], depth


@contextmanager
def _reading(recording: Path) -> Iterator[None]:
    """Raise NoDepthError for errors of reading."""
    try:
        yield
    except (OSError, RuntimeError, LookupError, TypeError, ValueError) as error:
        raise NoDepthError(f"{recording}: not a recording ({error}){_HINT}") from error


def chunks(recording: Path, *entities: str) -> Iterator[Any]:
    """The chunks of a recording that belong to some entities."""
    from rerun.chunk import RrdReader

    end, size = whole_size(recording), recording.stat().st_size
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        if end < size:  # Rerun reads nothing of a file that is cut within a message
            whole = Path(folder) / recording.name
            whole.write_bytes(recording.read_bytes()[:end])
            recording = whole
        warnings.filterwarnings("ignore", message="RRD file has no footer")
        yield from RrdReader(recording).stream().filter(content=list(entities)).to_chunks()


def _rows(recording: Path, entities: str = "/**") -> Iterator[_Row]:
    """Rows with depth images or camera models."""
    for chunk in chunks(recording, entities):
        batch = chunk.to_record_batch()
        names = batch.schema.names
        if not any("DepthImage:" in name or "Pinhole:" in name for name in names):
            continue
        timeline = "t" if "t" in names else "log_time" if "log_time" in names else None
        times = batch.column(timeline).cast("int64") if timeline else None
        for index in range(batch.num_rows):
            row = {name: batch.column(name)[index].as_py() for name in names if ":" in name}
            time = 1e-9 * times[index].as_py() if times is not None else 0.0
            yield {name: value for name, value in row.items() if value} | {"time": time}


def _has_depth(row: _Row) -> bool:
    return f"{_ENCODED}meter" in row or f"{_RAW}meter" in row


def _decoded(row: _Row) -> Image | None:
    """(H, W) depth [m]; None if the encoding is not supported."""
    import cv2

    if f"{_ENCODED}blob" in row:
        blob = np.frombuffer(bytes(row[f"{_ENCODED}blob"][0]), dtype=np.uint8)
        image = cv2.imdecode(blob, cv2.IMREAD_UNCHANGED)
        if image is None or image.ndim != 2:
            return None
        per_metre = row[f"{_ENCODED}meter"][0]
    else:
        kind = row[f"{_RAW}format"][0]
        pixels = np.frombuffer(bytes(row[f"{_RAW}buffer"][0]), _DTYPES[kind["channel_datatype"]])
        image = pixels.reshape(kind["height"], kind["width"])
        per_metre = row[f"{_RAW}meter"][0]
    return np.asarray(image / np.float32(per_metre), dtype=np.float32)
