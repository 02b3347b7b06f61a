"""Depth images out of a recording, of ours or of anybody who logs depth to Rerun."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
import numpy.typing as npt
from rerun.chunk import RrdReader

_ENCODED, _RAW = "EncodedDepthImage:", "DepthImage:"
_TYPES: dict[int, str] = {6: "u1", 7: "u2", 8: "u4", 33: "f2", 34: "f4", 35: "f8"}
"""Raw pixels by the number of Rerun's channel type."""


class NoDepthError(Exception):
    """The recording has no depth image that can be read; the text says why."""


class RecordedDepth(NamedTuple):
    """A depth image as it was recorded."""

    depth: npt.NDArray[np.float32]
    """(H, W) [m]; 0 where missing."""
    focal: float | None
    """Focal length [px], if the recording tells."""


def recorded_depth(recording: Path, at: float | None) -> RecordedDepth:
    """The depth image of a recording that is nearest to a time.

    Args:
        recording: an .rrd file.
        at: time on the recording's first timeline that counts from its start [s]; None takes the
            last image.

    Raises:
        NoDepthError: it is no recording, or holds no depth image.
    """
    focal: float | None = None
    best: tuple[float, dict[str, Any]] | None = None
    try:
        for batch in _batches(recording):
            for row in batch:
                if "Pinhole:image_from_camera" in row:
                    focal = float(row["Pinhole:image_from_camera"][0][0])
                if any(f"{kind}meter" in row for kind in (_ENCODED, _RAW)):
                    distance = -row["time"] if at is None else abs(row["time"] - at)
                    if best is None or distance <= best[0]:
                        best = distance, row
    except (OSError, RuntimeError, ValueError) as error:
        raise NoDepthError(f"not a recording that can be read ({error})") from error
    if best is None:
        raise NoDepthError("no depth image was recorded in it")
    return RecordedDepth(_decoded(best[1]), focal)


def _batches(recording: Path) -> Iterator[Iterator[dict[str, Any]]]:
    """Rows of every chunk, by component; times in seconds."""
    for chunk in RrdReader(recording).stream().to_chunks():
        batch = chunk.to_record_batch()
        if any("DepthImage:" in n or "Pinhole:" in n for n in batch.schema.names):
            yield _rows(batch)


def _rows(batch: Any) -> Iterator[dict[str, Any]]:
    names = batch.schema.names
    timeline = "t" if "t" in names else "log_time" if "log_time" in names else None
    times = batch.column(timeline).cast("int64") if timeline else None
    wanted = [n for n in names if ":" in n]
    for index in range(batch.num_rows):
        row: dict[str, Any] = {n: batch.column(n)[index].as_py() for n in wanted}
        row = {n: value for n, value in row.items() if value is not None}
        yield row | {"time": 1e-9 * times[index].as_py() if times is not None else 0.0}


def _decoded(row: dict[str, Any]) -> npt.NDArray[np.float32]:
    if f"{_ENCODED}blob" in row:
        blob = np.frombuffer(bytes(row[f"{_ENCODED}blob"][0]), dtype=np.uint8)
        image = cv2.imdecode(blob, cv2.IMREAD_UNCHANGED)
        if image is None or image.ndim != 2:
            raise NoDepthError("its depth images are encoded in a way that cannot be read")
        per_metre = row[f"{_ENCODED}meter"][0]
    else:
        kind = row[f"{_RAW}format"][0]
        pixels = np.frombuffer(bytes(row[f"{_RAW}buffer"][0]), _TYPES[kind["channel_datatype"]])
        image = pixels.reshape(kind["height"], kind["width"])
        per_metre = row[f"{_RAW}meter"][0]
    return np.asarray(image / np.float32(per_metre), dtype=np.float32)
