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
        lenses = [one for _, (one,) in _rows(recording, _CAMERA, _PINHOLE)]
        best = min(_encoded(recording), key=lambda one: _away(one[0], at), default=None)
        if best is not None:
            return RecordedDepth(_decoded(*best[1:]), float(lenses[-1][0][0]) if lenses else None)
    raise NoDepthError(f"{recording}: the recording has no depth images{_HINT}")


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


def _rows(recording: Path, entity: str, *names: str) -> Iterator[tuple[float, list[Any]]]:
    """Components of an entity at each time [s] that has all of them; 0 s if they are constant."""
    for chunk in chunks(recording, entity):
        batch = chunk.to_record_batch()
        if not {*names} <= {*batch.schema.names}:
            continue
        times = batch.column("t").cast("int64").to_pylist() if "t" in batch.schema.names else [0]
        for time, *cells in zip(times, *(batch.column(name) for name in names), strict=True):
            values = [cell.as_py() for cell in cells]
            if all(values):
                yield 1e-9 * time, values


def _encoded(recording: Path) -> Iterator[tuple[float, bytes, float]]:
    """Time [s], PNG and units a metre of each image."""
    for time, (blob, per_metre) in _rows(recording, f"{_CAMERA}/depth", _BLOB, _PER_METRE):
        yield time, bytes(blob[0]), float(per_metre[0])


def _away(time: float, at: float | None) -> float:
    """How far a time is from the wanted one; later ones are nearer if that is None."""
    return -time if at is None else abs(time - at)


def _decoded(blob: bytes, per_metre: float) -> Image:
    """(H, W) depth [m]."""
    import cv2

    image = cv2.imdecode(np.frombuffer(blob, np.uint8), cv2.IMREAD_UNCHANGED)
    if image is None or image.ndim != 2:
        raise ValueError("an image in it is damaged")
    return np.asarray(image / np.float32(per_metre), dtype=np.float32)
