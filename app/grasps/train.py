"""Make the grasp network's weights from nothing: render scenes, label them, train.

Counting steps, the same numbers give the same weights; in minutes, training fits into a time.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import torch

from app.grasps.generate import VIEWS, generate
from hw import stopwatch
from perception.network import save_network
from perception.training import Progress, Samples, train

_REPORT_EVERY = 100
_SCENES_AT_ONCE = 20

Say = Callable[[str], None]


def make_weights(
    out: Path,
    *,
    images: int,
    seed: int,
    steps: int | None,
    minutes: float,
    samples_file: Path | None,
    say: Say,
) -> None:
    """Train on rendered scenes and save what comes of it.

    Args:
        out: where the weights go, with a note of how they were made.
        images: how many to render and learn from.
        seed: of scenes, noise and training.
        steps: how long to train; None goes by `minutes`.
        minutes: how long to train [min].
        samples_file: the rendered images are read from here if it exists, else kept here.
        say: told now and then how far it is.
    """
    torch.set_num_threads(1)
    samples = _samples(images, seed, samples_file, say)
    reports: list[Progress] = []
    schedule = _schedule(steps, minutes, reports, say)
    network = train(samples, seed=seed, elapsed=schedule)
    last = reports[-1]
    metadata = {
        "network": "GG-CNN",
        "data": f"{len(samples)} images of scenes made by app.grasps.generate, seed {seed}",
        "training": f"{last.step} steps, final loss {last.loss:.4f}",
        "licence": "Apache-2.0",
    }
    save_network(network, out, metadata)
    say(f"{out}: {metadata['data']}; {metadata['training']}")


def _samples(images: int, seed: int, path: Path | None, say: Say) -> Samples:
    if path is not None and path.is_file():
        return Samples.load(path)
    begun = stopwatch()
    scenes = -(-images // VIEWS)
    made = []
    for first in range(0, scenes, _SCENES_AT_ONCE):
        made += generate(min(_SCENES_AT_ONCE, scenes - first), seed, first)
        say(f"{len(made)} of {scenes * VIEWS} images, {stopwatch() - begun:.0f} s")
    samples = Samples(made)
    if path is not None:
        samples.save(path)
    return samples


def _schedule(
    steps: int | None, minutes: float, reports: list[Progress], say: Say
) -> Callable[[Progress], float]:
    """What `train` asks before every step: how much of it is over."""
    begun = stopwatch()

    def part(progress: Progress) -> float:
        reports[:] = [progress]
        if progress.step % _REPORT_EVERY == 0:
            say(f"step {progress.step}, loss {progress.loss:.4f}, {stopwatch() - begun:.0f} s")
        return progress.step / steps if steps else (stopwatch() - begun) / (60.0 * minutes)

    return part
