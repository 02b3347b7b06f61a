"""Training samples of grasp networks: images, dense labels, shards of them, and random windows.

Shards are compressed files of a few hundred images in integers. A `SampleStream` keeps some of them
in memory and draws windows, rotated, mirrored and zoomed at random.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

from config.arrays import Image
from perception import ANGLE_BINS, GRID_SIZE, OUTPUT_STRIDE, WIDTH_SCALE

WINDOW = 192  # side of the part of an image that a training step uses [px]
ZOOM = 1.2  # windows are cut larger or smaller by at most this factor
_SPAN = WINDOW // OUTPUT_STRIDE  # side of a window [cells]


@dataclass(frozen=True, kw_only=True, eq=False)
class Labels:
    """Desired output of a network at the cells that show an object; quality is 0 elsewhere."""

    cell: npt.NDArray[np.int16]  # (N,) row * GRID_SIZE + column
    quality: Image  # (N, ANGLE_BINS) 0 to 1
    width: Image  # (N, ANGLE_BINS) distance between the contacts [input px]


@dataclass(frozen=True, kw_only=True, eq=False)
class Sample:
    """One image and its labels."""

    image: Image  # (INPUT_SIZE, INPUT_SIZE) the network's input [m]
    labels: Labels


class Batch(NamedTuple):
    """Windows of one training step, n = WINDOW / OUTPUT_STRIDE."""

    image: Image  # (B, 1, WINDOW, WINDOW) [m]
    quality: Image  # (B, ANGLE_BINS, n, n)
    width: Image  # (B, ANGLE_BINS, n, n) [input px / WIDTH_SCALE]
    on_object: Image  # (B, n, n) 1 where a cell shows an object


@dataclass(frozen=True, kw_only=True, eq=False)
class Shard:
    """Samples as integers."""

    image: npt.NDArray[np.int16]  # (S, INPUT_SIZE, INPUT_SIZE) [0.1 mm]
    first: npt.NDArray[np.int64]  # (S + 1,) first cell of each sample, and the end
    cell: npt.NDArray[np.int16]  # (N,) row * GRID_SIZE + column
    quality: npt.NDArray[np.uint8]  # (N, ANGLE_BINS) [1/255]
    width: npt.NDArray[np.uint8]  # (N, ANGLE_BINS) [half input px]

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
        """Write a compressed file, atomically."""
        part = path.with_suffix(".part")
        with part.open("wb") as file:
            np.savez_compressed(file, **{f.name: getattr(self, f.name) for f in fields(self)})
        part.replace(path)

    @classmethod
    def load(cls, path: Path) -> Shard:
        """Read a file that `save` wrote."""
        with np.load(path) as file:
            return cls(**{f.name: file[f.name] for f in fields(cls)})

    def dense(self, index: int) -> tuple[Image, Image, Image]:
        """Dense labels of a sample.

        Returns:
            (n, n, ANGLE_BINS) quality and width [input px], and the (n, n) mask of objects.
        """
        part = slice(self.first[index], self.first[index + 1])
        grids = []
        for values, unit in ((self.quality, 255.0), (self.width, 2.0)):
            grid = np.zeros((GRID_SIZE * GRID_SIZE, ANGLE_BINS), dtype=np.float32)
            grid[self.cell[part]] = values[part] / np.float32(unit)
            grids.append(grid.reshape(GRID_SIZE, GRID_SIZE, ANGLE_BINS))
        on_object = np.zeros(GRID_SIZE * GRID_SIZE, dtype=np.float32)
        on_object[self.cell[part]] = 1.0
        return grids[0], grids[1], on_object.reshape(GRID_SIZE, GRID_SIZE)


class SampleStream:
    """Random windows from shards, `in_memory` at a time; all follows from the seed."""

    def __init__(self, paths: Sequence[Path], seed: int, in_memory: int = 12) -> None:
        self._paths = list(paths)
        self._rng = np.random.default_rng(seed)
        self._queue: list[Path] = []
        self._shards = [self._next_shard() for _ in range(min(in_memory, len(self._paths)))]
        self._drawn = 0

    def _next_shard(self) -> Shard:
        if not self._queue:
            order = self._rng.permutation(len(self._paths))
            self._queue = [self._paths[i] for i in order]
        return Shard.load(self._queue.pop())

    def draw(self, size: int) -> Batch:
        """Windows of `size` random samples.

        The oldest shard in memory is replaced after as many windows as it has samples.
        """
        rng = self._rng
        windows = []
        for _ in range(size):
            shard = self._shards[rng.integers(len(self._shards))]
            windows.append(_window(shard, int(rng.integers(len(shard))), rng))
        self._drawn += size
        if len(self._shards) < len(self._paths) and self._drawn >= len(self._shards[0]):
            self._drawn = 0
            self._shards = [*self._shards[1:], self._next_shard()]
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
    """A window of a sample with a grasp in it, zoomed, rotated and perhaps mirrored."""
    quality, width, on_object = shard.dense(index)
    span = round(_SPAN * ZOOM ** rng.uniform(-1.0, 1.0))
    row, column = _corner(quality, span, rng)
    chosen = (np.arange(_SPAN) * span) // _SPAN  # nearest cells: labels are not averaged
    rows, columns = row + chosen, column + chosen
    part = shard.image[
        index,
        OUTPUT_STRIDE * row : OUTPUT_STRIDE * (row + span),
        OUTPUT_STRIDE * column : OUTPUT_STRIDE * (column + span),
    ]
    image = cv2.resize(
        part.astype(np.float32) * np.float32(1e-4),
        (WINDOW, WINDOW),
        interpolation=cv2.INTER_AREA if span > _SPAN else cv2.INTER_LINEAR,
    )
    turns, mirrored = int(rng.integers(4)), rng.random() < 0.5
    quality, width, on_object, image = (
        _rotated(np.asarray(layer), turns, mirrored)
        for layer in (
            quality[np.ix_(rows, columns)],
            width[np.ix_(rows, columns)] * np.float32(_SPAN / span / WIDTH_SCALE),
            on_object[np.ix_(rows, columns)],
            image,
        )
    )
    return image, quality, width, on_object


def _rotated(layer: Image, turns: int, mirrored: bool) -> Image:
    """Rotated anticlockwise by right angles, then mirrored left to right, directions included."""
    layer = np.rot90(layer, turns)
    if layer.ndim == 3 and turns % 2:
        layer = np.roll(layer, ANGLE_BINS // 2, axis=2)
    if mirrored:
        layer = layer[:, ::-1]
        if layer.ndim == 3:
            layer = layer[:, :, -np.arange(ANGLE_BINS) % ANGLE_BINS]
    return np.ascontiguousarray(layer)


def _corner(quality: Image, span: int, rng: np.random.Generator) -> tuple[int, int]:
    """First row and column of a window that contains a random graspable cell."""
    last = GRID_SIZE - span
    rows, columns = np.nonzero(quality.max(axis=2) > 0.1)
    if len(rows) == 0:
        return int(rng.integers(last + 1)), int(rng.integers(last + 1))
    chosen = rng.integers(len(rows))
    row, column = np.array([rows[chosen], columns[chosen]]) - rng.integers(0, span, 2)
    return int(np.clip(row, 0, last)), int(np.clip(column, 0, last))
