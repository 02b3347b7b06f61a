"""Depth images from the recording of a run."""

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

_CAMERA = "/world/camera"
_BLOB, _PER_METRE = "EncodedDepthImage:blob", "EncodedDepthImage:meter"
_PINHOLE = "Pinhole:image_from_camera"
_HINT = "; use a recording with depth images"


class NoDepthError(UserError):
    """The recording has no readable depth image."""


class RecordedDepth(NamedTuple):
    """A recorded depth image."""

    depth: Image  # (H, W) [m]; 0 where missing
    focal: float | None  # focal length [px], if it was recorded


def recorded_depth(recording: Path, at: float | None) -> RecordedDepth:
    """The depth image of a recording nearest to a session time [s]; None takes the last.

    Raises NoDepthError: it is not a recording, or has no depth image.
    """
    with _reading(recording):
        images = list(_encoded(recording))
        lenses = [one[0] for _, one in _column(recording, _CAMERA, _PINHOLE)]
    if not images:
        raise NoDepthError(f"{recording}: the recording has no depth images{_HINT}")
    best = images[-1] if at is None else min(images, key=lambda one: abs(one[0] - at))
    with _reading(recording):
        return RecordedDepth(_decoded(*best[1:]), float(lenses[-1][0]) if lenses else None)


def depth_images(recording: Path) -> Iterator[tuple[float, Image]]:
    """All depth images of a recording: session time [s], and (H, W) [m], 0 where missing.

    Raises NoDepthError: it is not a recording, or an image in it is damaged.
    """
    with _reading(recording):
        for time, blob, per_metre in _encoded(recording):
            yield time, _decoded(blob, per_metre)


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


def _column(recording: Path, entity: str, name: str) -> Iterator[tuple[float, Any]]:
    """What a component of an entity was at each time [s]; 0 s if it is constant."""
    for chunk in chunks(recording, entity):
        batch = chunk.to_record_batch()
        if name in batch.schema.names:
            is_timed = "t" in batch.schema.names
            times = batch.column("t").cast("int64").to_pylist() if is_timed else [0]
            rows = zip(times, batch.column(name), strict=True)
            yield from ((1e-9 * time, one.as_py()) for time, one in rows if one.as_py())


def _encoded(recording: Path) -> Iterator[tuple[float, bytes, float]]:
    """Time [s], PNG and units a metre of each image."""
    scales = [one[0] for _, one in _column(recording, f"{_CAMERA}/depth", _PER_METRE)]
    images = _column(recording, f"{_CAMERA}/depth", _BLOB)
    for (time, blob), per_metre in zip(images, scales, strict=True):
        yield time, bytes(blob[0]), float(per_metre)


def _decoded(blob: bytes, per_metre: float) -> Image:
    """(H, W) depth [m]."""
    import cv2

    image = cv2.imdecode(np.frombuffer(blob, np.uint8), cv2.IMREAD_UNCHANGED)
    if image is None or image.ndim != 2:
        raise ValueError("an image in it is damaged")
    return np.asarray(image / np.float32(per_metre), dtype=np.float32)
