"""Depth images of runs as a video, a picture per frame of the data.

A picture has 8 bits a pixel, equal in all three channels: 0 where nothing was measured, 1 to 255
for `NEAR` to `FAR`. The video is lossy.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from app.core import FRAMES, RECORDING
from app.review import NoDepthError, depth_images
from config.arrays import Image, Indices
from extensions.export.episodes import Episode, ExportError

NEAR, FAR = 0.1, 1.5  # what 1 and 255 stand for [m]
WIDEST = 320  # largest width of a picture [px]; larger images are subsampled
CODEC = "vp9"
_FOURCC = "vp09"

Picture = npt.NDArray[np.uint8]
Images = list[tuple[float, Picture]]  # time [s] and picture (H, W), in order


@dataclass(frozen=True, kw_only=True)
class Video:
    """Size [px] and statistics of a video."""

    height: int
    width: int
    levels: Indices  # (256,) number of pixels of each value

    def statistics(self) -> dict[str, Any]:
        """Statistics of the values, scaled to 0 to 1, for each channel."""
        values, count = np.arange(256) / 255.0, self.levels.sum()
        mean = float((values * self.levels).sum() / count)
        deviation = float(np.sqrt(((values - mean) ** 2 * self.levels).sum() / count))
        there = values[self.levels > 0]
        found = {"min": there.min(), "max": there.max(), "mean": mean, "std": deviation}
        alike = {name: [[[float(value)]]] * 3 for name, value in found.items()}
        return alike | {"count": [int(count // (self.height * self.width))]}


def images_of(folder: Path) -> Images:
    """The depth images of a run; all of them after `run --replayable`, else the recorded ones."""
    kept = folder / FRAMES
    found = _kept(kept) if kept.is_file() else _recorded(folder / RECORDING)
    return sorted(found, key=lambda one: one[0])


def write_video(path: Path, episodes: Sequence[Episode], fps: int) -> Video | None:
    """Write the pictures of all episodes, one after the other; None if a run has no pictures.

    A frame has the newest picture at its time; before the first one it is black. Raises
    ExportError: it cannot be written.
    """
    import cv2

    images = {folder: images_of(folder) for folder in {one.folder for one in episodes}}
    if not all(images.values()):
        return None
    sizes = {one[1].shape for found in images.values() for one in found}
    if len(sizes) > 1:
        raise ExportError("the runs have pictures of different sizes: export them separately")
    height, width = sizes.pop()
    path.parent.mkdir(parents=True, exist_ok=True)
    fourcc = cv2.VideoWriter.fourcc(*_FOURCC)
    video = cv2.VideoWriter(str(path), fourcc, float(fps), (width, height))
    if not video.isOpened():
        raise ExportError(f"{path}: OpenCV cannot write a video in {CODEC} here")
    levels = np.zeros(256, np.int64)
    for episode in episodes:
        for picture in _in_step(images[episode.folder], episode.stamps, (height, width)):
            levels += np.bincount(picture.ravel(), minlength=256)
            video.write(np.repeat(picture[:, :, None], 3, axis=2))
    video.release()
    return Video(height=height, width=width, levels=levels)


def pictured(depth: Image) -> Picture:
    """A depth image (H, W) [m] as 8 bits a pixel, at most `WIDEST` wide."""
    step = -(-depth.shape[1] // WIDEST)
    depth = depth[::step, ::step]
    known = np.isfinite(depth) & (depth > 0.0)
    share = np.clip((np.nan_to_num(depth) - NEAR) / (FAR - NEAR), 0.0, 1.0)
    return np.where(known, np.rint(1.0 + 254.0 * share), 0.0).astype(np.uint8)


def _in_step(images: Images, stamps: Any, size: tuple[int, int]) -> Iterator[Picture]:
    times = np.array([time for time, _ in images])
    for newest in np.searchsorted(times, stamps + 1e-9) - 1:
        yield images[newest][1] if newest >= 0 else np.zeros(size, np.uint8)


def _recorded(recording: Path) -> Images:
    try:
        return [(time, pictured(depth)) for time, depth in depth_images(recording)]
    except NoDepthError:
        return []


def _kept(path: Path) -> Images:
    import pyarrow as pa

    found: Images = []
    try:
        for batch in pa.ipc.open_stream(pa.memory_map(str(path))):
            shape = batch["shape"].flatten().to_numpy()
            depth = batch["depth"].flatten().to_numpy().reshape(shape)
            found.append((float(batch["stamp"][0].as_py()), pictured(depth)))
    except (OSError, ValueError, LookupError, pa.ArrowException):
        return found  # what a kill has left of it
    return found
