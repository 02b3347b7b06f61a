"""What a grasp network learns from: images, and what would be right at every pixel.

Samples are kept in shards, files of a few hundred images in few bytes (tenths of a millimetre,
hundredths of a quality). A `SampleStream` holds some shards at a time and draws windows from them,
turned, mirrored and zoomed at random, so that any amount of data fits into little memory.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

from perception.arrays import Image
from perception.maps import BINS, CELLS, STRIDE, WIDTH_SCALE

WINDOW = 192
"""Side of the part of an image that one step looks at [px]."""
ZOOM = 1.2
"""Windows are taken this much larger or smaller at most, then brought to their size."""
_SPAN = WINDOW // STRIDE


@dataclass(frozen=True, kw_only=True, eq=False)
class Labels:
    """What a network should answer at the cells that show an object; quality is 0 elsewhere."""

    cell: npt.NDArray[np.int16]
    """(N,) row * CELLS + column."""
    quality: Image
    """(N, BINS) 0 to 1."""
    width: Image
    """(N, BINS) opening that the object needs [network px]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sample:
    """One image and its labels."""

    image: Image
    """(SIZE, SIZE) as the network takes it [m]."""
    labels: Labels


class Batch(NamedTuple):
    """What one step learns from."""

    image: Image
    """(B, 1, WINDOW, WINDOW) [m]."""
    quality: Image
    """(B, BINS, n, n) with n = WINDOW / STRIDE."""
    width: Image
    """(B, BINS, n, n) [network px / WIDTH_SCALE]."""
    on_object: Image
    """(B, n, n) 1 where a cell shows an object."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Shard:
    """Many samples in few bytes."""

    image: npt.NDArray[np.int16]
    """(S, SIZE, SIZE) [0.1 mm]."""
    first: npt.NDArray[np.int64]
    """(S + 1,) where the cells of each sample begin."""
    cell: npt.NDArray[np.int16]
    """(N,)."""
    quality: npt.NDArray[np.uint8]
    """(N, BINS) 255 is 1."""
    width: npt.NDArray[np.uint8]
    """(N, BINS) [half network px]."""

    @classmethod
    def of(cls, samples: Sequence[Sample]) -> Shard:
        """Pack samples."""
        labels = [s.labels for s in samples]
        return cls(
            image=np.stack([np.rint(s.image * 1e4).astype(np.int16) for s in samples]),
            first=np.cumsum([0, *(len(each.cell) for each in labels)], dtype=np.int64),
            cell=np.concatenate([each.cell for each in labels]),
            quality=np.concatenate([np.rint(each.quality * 255.0) for each in labels]).astype("u1"),
            width=np.concatenate(
                [np.clip(np.rint(each.width * 2.0), 0, 255) for each in labels]
            ).astype("u1"),
        )

    def __len__(self) -> int:
        return len(self.image)

    def save(self, path: Path) -> None:
        """Write a compressed file, whole or not at all."""
        part = path.with_suffix(".part")
        with part.open("wb") as file:
            np.savez_compressed(file, **{f.name: getattr(self, f.name) for f in fields(self)})
        part.replace(path)

    @classmethod
    def load(cls, path: Path) -> Shard:
        """Read what `save` wrote."""
        with np.load(path) as file:
            return cls(**{f.name: file[f.name] for f in fields(cls)})

    def dense(self, index: int) -> tuple[Image, Image, Image]:
        """Labels of a sample on the whole grid.

        Returns:
            (CELLS, CELLS, BINS) quality and width [network px], (CELLS, CELLS) on an object.
        """
        part = slice(self.first[index], self.first[index + 1])
        grids = []
        for values, unit in ((self.quality, 255.0), (self.width, 2.0)):
            grid = np.zeros((CELLS * CELLS, BINS), dtype=np.float32)
            grid[self.cell[part]] = values[part] / np.float32(unit)
            grids.append(grid.reshape(CELLS, CELLS, BINS))
        on_object = np.zeros(CELLS * CELLS, dtype=np.float32)
        on_object[self.cell[part]] = 1.0
        return grids[0], grids[1], on_object.reshape(CELLS, CELLS)


class SampleStream:
    """Random windows out of shards, of which only some are in memory.

    Args:
        paths: of the shards.
        seed: of everything random.
        held: shards in memory at a time.
    """

    def __init__(self, paths: Sequence[Path], seed: int, held: int = 12) -> None:
        self._paths = list(paths)
        self._rng = np.random.default_rng(seed)
        self._waiting: list[Path] = []
        self._held = [self._next_shard() for _ in range(min(held, len(self._paths)))]
        self._drawn = 0

    def _next_shard(self) -> Shard:
        if not self._waiting:
            order = self._rng.permutation(len(self._paths))
            self._waiting = [self._paths[i] for i in order]
        return Shard.load(self._waiting.pop())

    def draw(self, size: int) -> Batch:
        """Windows of `size` random samples.

        Every shard in memory is replaced once as many windows as it has samples were drawn from
        each, the oldest first.
        """
        rng = self._rng
        windows = []
        for _ in range(size):
            shard = self._held[rng.integers(len(self._held))]
            windows.append(_window(shard, int(rng.integers(len(shard))), rng))
        self._drawn += size
        if len(self._held) < len(self._paths) and self._drawn >= len(self._held[0]):
            self._drawn = 0
            self._held = [*self._held[1:], self._next_shard()]
        image, quality, width, on_object = (np.stack(each) for each in zip(*windows, strict=True))
        return Batch(
            image=image[:, None],
            quality=quality.transpose(0, 3, 1, 2),
            width=width.transpose(0, 3, 1, 2),
            on_object=on_object,
        )


def _window(
    shard: Shard, index: int, rng: np.random.Generator
) -> tuple[Image, Image, Image, Image]:
    """A part of a sample about something to grasp, zoomed, turned and perhaps mirrored."""
    quality, width, on_object = shard.dense(index)
    span = round(_SPAN * ZOOM ** rng.uniform(-1.0, 1.0))
    row, column = _corner(quality, span, rng)
    chosen = (np.arange(_SPAN) * span) // _SPAN  # labels are not averaged
    rows, columns = row + chosen, column + chosen
    part = shard.image[
        index, STRIDE * row : STRIDE * (row + span), STRIDE * column : STRIDE * (column + span)
    ]
    image = cv2.resize(
        part.astype(np.float32) * np.float32(1e-4),
        (WINDOW, WINDOW),
        interpolation=cv2.INTER_AREA if span > _SPAN else cv2.INTER_LINEAR,
    )
    turns, mirrored = int(rng.integers(4)), rng.random() < 0.5
    quality, width, on_object, image = (
        _turned(np.asarray(layer), turns, mirrored)
        for layer in (
            quality[np.ix_(rows, columns)],
            width[np.ix_(rows, columns)] * np.float32(_SPAN / span / WIDTH_SCALE),
            on_object[np.ix_(rows, columns)],
            image,
        )
    )
    return image, quality, width, on_object


def _turned(layer: Image, turns: int, mirrored: bool) -> Image:
    """Turned anticlockwise by right angles, then mirrored left to right; bins go along."""
    layer = np.rot90(layer, turns)
    if layer.ndim == 3 and turns % 2:
        layer = np.roll(layer, BINS // 2, axis=2)
    if mirrored:
        layer = layer[:, ::-1]
        if layer.ndim == 3:
            layer = layer[:, :, -np.arange(BINS) % BINS]
    return np.ascontiguousarray(layer)


def _corner(quality: Image, span: int, rng: np.random.Generator) -> tuple[int, int]:
    """First row and column of a window that something to grasp is somewhere in."""
    last = CELLS - span
    rows, columns = np.nonzero(quality.max(axis=2) > 0.1)
    if len(rows) == 0:
        return int(rng.integers(last + 1)), int(rng.integers(last + 1))
    chosen = rng.integers(len(rows))
    row, column = np.array([rows[chosen], columns[chosen]]) - rng.integers(0, span, 2)
    return int(np.clip(row, 0, last)), int(np.clip(column, 0, last))
