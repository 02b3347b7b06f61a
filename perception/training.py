"""Teaching the network: samples, the loss, and the loop.

The published loss is the squared error of all four maps over all pixels, which is mostly error on
pixels where there is nothing to grasp. Here angle and width count only where a grasp would work,
each pixel by how well it would, and quality counts more on objects than beside them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from perception.arrays import Image, Indices
from perception.maps import SIZE, WIDTH_SCALE
from perception.network import GGCNN, evaluate, rewritten

LABEL_STRIDE = 3
"""Network pixels to a label; labels stand for the square of that side around them."""
LABEL_SIZE = SIZE // LABEL_STRIDE

WINDOW = 192
"""Side of the part of an image that one step looks at; a multiple of 12 [px]."""

_BACKGROUND = 0.15  # weight of quality beside objects
_WELL_GRASPED = 6.0  # additional weight of quality where it is 1
_QUALITY, _WIDTH = 8.0, 40.0  # weights of these losses; that of the angle is 1


@dataclass(frozen=True, kw_only=True, eq=False)
class Labels:
    """What the network should answer, on a coarser grid."""

    quality: Image
    """(100, 100) 0 to 1."""
    angle: Image
    """(100, 100) closing direction, anticlockwise as seen, in [0, π) [rad]."""
    width: Image
    """(100, 100) [network px]."""
    on_object: npt.NDArray[np.bool_]
    """(100, 100)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sample:
    """One image and its labels."""

    image: Image
    """(300, 300) as the network takes it [m]."""
    labels: Labels


_ARRAYS = ("image", "quality", "angle", "width", "on_object")


class Samples:
    """Many samples in little memory: tenths of a millimetre and bytes.

    Args:
        samples: the samples to keep.
    """

    def __init__(self, samples: Sequence[Sample]) -> None:
        self._image = np.stack([np.rint(s.image * 1e4).astype(np.int16) for s in samples])
        self._quality = np.stack([np.rint(s.labels.quality * 255.0) for s in samples]).astype("u1")
        self._angle = np.stack([np.rint(s.labels.angle * 255.0 / np.pi) for s in samples]).astype(
            "u1"
        )
        self._width = np.stack(
            [np.clip(np.rint(s.labels.width * 2.0), 0, 255) for s in samples]
        ).astype("u1")
        self._on_object = np.stack([s.labels.on_object for s in samples])

    def __len__(self) -> int:
        return len(self._image)

    def save(self, path: Path) -> None:
        """Write to an npz file."""
        with path.open("wb") as file:
            np.savez(file, **{name: getattr(self, f"_{name}") for name in _ARRAYS})

    @classmethod
    def load(cls, path: Path) -> Samples:
        """Read what `save` wrote."""
        samples = cls.__new__(cls)
        with np.load(path) as file:
            for name in _ARRAYS:
                setattr(samples, f"_{name}", file[name])
        return samples

    def batch(self, size: int, indices: Indices, rng: np.random.Generator) -> Batch:
        """A random window of each of some samples, about something to grasp, perhaps mirrored.

        Only mirrored, not turned: labels prefer closing along u where directions are equally good,
        and that has to stay so.
        """
        flip_u, flip_v = rng.random(2) < 0.5
        span = size // LABEL_STRIDE
        corners = [self._corner(index, span, rng) for index in indices]

        def windows(values: npt.NDArray[Any], stride: int) -> Image:
            parts = [
                values[i, stride * r : stride * (r + span), stride * c : stride * (c + span)]
                for i, (r, c) in zip(indices, corners, strict=True)
            ]
            return np.stack(parts).astype(np.float32)

        image = windows(self._image, LABEL_STRIDE) / 1e4
        angle = windows(self._angle, 1) * np.float32(np.pi / 255.0)
        if flip_u != flip_v:
            angle = -angle
        target = np.stack(
            [
                windows(self._quality, 1) / 255.0,
                np.cos(2.0 * angle),
                np.sin(2.0 * angle),
                windows(self._width, 1) / (2.0 * WIDTH_SCALE),
                windows(self._on_object, 1),
            ],
            axis=1,
        )
        axes = tuple(axis for axis, flip in ((-1, flip_u), (-2, flip_v)) if flip)
        return Batch(
            image=torch.from_numpy(np.flip(image[:, None], axes).copy()),
            target=torch.from_numpy(np.flip(target, axes).copy()),
        )

    def _corner(self, index: int, span: int, rng: np.random.Generator) -> tuple[int, int]:
        """First row and column, in labels, of a window that something to grasp is somewhere in."""
        rows, columns = np.nonzero(self._quality[index] > 0)
        last = LABEL_SIZE - span
        if len(rows) == 0:
            return int(rng.integers(last + 1)), int(rng.integers(last + 1))
        chosen = rng.integers(len(rows))
        row, column = np.array([rows[chosen], columns[chosen]]) - rng.integers(0, span, 2)
        return int(np.clip(row, 0, last)), int(np.clip(column, 0, last))


@dataclass(frozen=True, kw_only=True, eq=False)
class Batch:
    """What one step learns from."""

    image: Tensor
    """(B, 1, n, n)."""
    target: Tensor
    """(B, 5, n / 3, n / 3) quality, cosine, sine, width / 150 px, on an object."""


def loss(maps: Tensor, target: Tensor) -> Tensor:
    """Weighted squared error.

    Args:
        maps: (B, 4, n, n) the network's answer.
        target: (B, 5, n / 3, n / 3) of the batch.
    """
    target = target.repeat_interleave(LABEL_STRIDE, 2).repeat_interleave(LABEL_STRIDE, 3)
    quality, on_object = target[:, 0], target[:, 4]
    error = (maps - target[:, :4]) ** 2
    weight = _BACKGROUND + (1.0 - _BACKGROUND) * on_object + _WELL_GRASPED * quality
    graspable = quality * (quality > 0.1)
    total = graspable.sum() + 1.0
    of_quality = (weight * error[:, 0]).sum() / weight.sum()
    of_angle = (graspable[:, None] * error[:, 1:3]).sum() / total
    of_width = (graspable * error[:, 3]).sum() / total
    return _QUALITY * of_quality + of_angle + _WIDTH * of_width


@dataclass(frozen=True, kw_only=True)
class Progress:
    """How training is doing."""

    step: int
    loss: float
    """Smoothed over about fifty steps."""


def train(
    samples: Samples,
    *,
    seed: int,
    elapsed: Callable[[Progress], float],
    batch_size: int = 8,
    learning_rate: float = 2e-3,
) -> GGCNN:
    """Teach a new network.

    Args:
        samples: what to learn from.
        seed: of the first weights and of the order of samples.
        elapsed: called before every step; how much of the training is over, from 0 to 1. The
            learning rate follows it, and at 1 training ends. Counting steps makes training
            repeatable; asking a clock makes it fit into a time.
        batch_size: samples to a step.
        learning_rate: of Adam, at its highest.

    Returns:
        The network with the moving average of the weights.
    """
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    network = GGCNN()
    average = {name: value.clone() for name, value in network.state_dict().items()}
    optimizer = torch.optim.Adam(network.parameters(), lr=learning_rate)
    order = np.zeros(0, dtype=np.int64)
    step, smoothed = 0, 0.0
    while (part := elapsed(Progress(step=step, loss=smoothed))) < 1.0:
        if len(order) < batch_size:
            order = np.concatenate([order, rng.permutation(len(samples))])
        indices, order = order[:batch_size], order[batch_size:]
        batch = samples.batch(WINDOW, indices, rng)
        for group in optimizer.param_groups:
            group["lr"] = learning_rate * min(1.0, (step + 1) / 100) * _cosine(part)
        with torch.autocast("cpu", dtype=torch.bfloat16):
            maps = evaluate(
                rewritten(network), batch.image.contiguous(memory_format=torch.channels_last)
            )
        error = loss(maps.float(), batch.target)
        optimizer.zero_grad(set_to_none=True)
        error.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(network.parameters(), 5.0)
        optimizer.step()
        step += 1
        keep = min(0.998, step / (step + 10.0))
        for name, value in network.state_dict().items():
            average[name].lerp_(value, 1.0 - keep)
        blend = max(0.02, 1.0 / step)
        smoothed += blend * (float(error.detach()) - smoothed)
    network.load_state_dict(average)
    return network.eval()


def _cosine(part: float) -> float:
    """From 1 down to 0.02."""
    return 0.02 + 0.98 * 0.5 * (1.0 + float(np.cos(np.pi * part)))
