"""Lossless depth frames on disk: a stream of Arrow record batches, one a frame, with zstd.

A stream that was cut off is readable up to there.
"""

from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from config import UserError
from hw import DepthFrame
from robots import Intrinsics

_LEVEL = 3


class FrameStream:
    """Encodes numbered frames, in order."""

    def __init__(self) -> None:
        import pyarrow as pa

        self._bytes, zstd = BytesIO(), pa.Codec("zstd", _LEVEL)
        options = pa.ipc.IpcWriteOptions(compression=zstd)
        self._writer = pa.ipc.new_stream(self._bytes, _schema(), options=options)

    def __call__(self, frames: Sequence[tuple[int, DepthFrame]]) -> bytes:
        """Encode some more frames."""
        import pyarrow as pa

        for number, frame in frames:
            if frame.depth.dtype != np.float32:
                raise TypeError(f"a depth image of {frame.depth.dtype}, not float32")
            columns = (
                [number],
                [frame.stamp],
                [np.array(frame.oTc.homogeneous)[:3].ravel()],
                [list(frame.depth.shape)],
                [frame.depth.ravel()],
                [None if frame.colour is None else frame.colour.ravel()],
            )
            arrays = [pa.array(c, f.type) for c, f in zip(columns, _schema(), strict=True)]
            self._writer.write_batch(pa.record_batch(arrays, schema=_schema()))
        written = self._bytes.getvalue()
        self._bytes.seek(0)
        self._bytes.truncate()
        return written


def _schema() -> Any:
    import pyarrow as pa

    return pa.schema(
        [
            ("number", pa.int32()),
            ("stamp", pa.float64()),
            ("wTc", pa.list_(pa.float64(), 12)),
            ("shape", pa.list_(pa.int32())),
            ("depth", pa.list_(pa.float32())),
            ("colour", pa.list_(pa.uint8())),
        ]
    )


class RecordedFrames:
    """Reads the frames of a run, in order; raises UserError if the file cannot be read."""

    def __init__(self, path: Path, intrinsics: Intrinsics) -> None:
        import pyarrow as pa

        self._path = path
        self._intrinsics = intrinsics
        try:
            self._batches = iter(pa.ipc.open_stream(pa.memory_map(str(path))))
        except (OSError, pa.ArrowException) as error:
            raise UserError(f"{path}: cannot be read ({error})") from error

    def __call__(self, number: int) -> DepthFrame:
        """A frame; numbers only go up. Raises UserError: it is not there."""
        import pyarrow as pa

        try:
            batch = next(b for b in self._batches if b["number"][0].as_py() == number)
            pose = batch["wTc"].flatten().to_numpy().reshape(3, 4)
            shape = batch["shape"].flatten().to_numpy()
            return DepthFrame(
                depth=batch["depth"].flatten().to_numpy().reshape(shape),
                intrinsics=self._intrinsics,
                oTc=SE3(pose[:, :3].copy(), pose[:, 3].copy()),
                stamp=batch["stamp"][0].as_py(),
                paint=_paint(batch, shape),
            )
        except (StopIteration, OSError, pa.ArrowException):
            raise UserError(f"{self._path}: frame {number} is missing") from None
        except (LookupError, ValueError, TypeError) as error:
            raise UserError(f"{self._path}: frame {number} is damaged ({error})") from error


def _paint(batch: Any, shape: npt.NDArray[np.int32]) -> Callable[[], npt.NDArray[np.uint8]] | None:
    """The colours of a frame; None if its camera had none, or the run is of an older version."""
    if "colour" not in batch.schema.names or batch["colour"].null_count:
        return None
    colour: npt.NDArray[np.uint8] = batch["colour"].flatten().to_numpy().reshape(*shape, 3)
    return lambda: colour
