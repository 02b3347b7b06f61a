"""Make the grasp network's weights from nothing: render scenes, label them, train.

    python -m app.grasps.train --images 4200 --steps 3600 --seed 0 --out ggcnn.safetensors

Counting steps, the same numbers give the same weights; with `--minutes` training fits into a time.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

import torch

from app.grasps.generate import VIEWS, generate
from hw import stopwatch
from perception.network import save_network
from perception.training import Progress, Samples, train

_REPORT_EVERY = 100
_SCENES_AT_ONCE = 20


def main(arguments: Sequence[str] | None = None) -> None:
    """Run from the command line.

    Args:
        arguments: of the command line; None takes those of the process.
    """
    parser = argparse.ArgumentParser(prog="frankie-task grasp train", description=__doc__)
    parser.add_argument("--images", type=int, default=4200, help="rendered images to learn from")
    parser.add_argument("--steps", type=int, help="how many steps to train (repeatable)")
    parser.add_argument("--minutes", type=float, help="how long to train; default 30")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, required=True, help="where the weights go")
    parser.add_argument("--samples", type=Path, help="npz of the images: used, or else written")
    given = parser.parse_args(arguments)
    torch.set_num_threads(1)
    samples = _samples(given.images, given.seed, given.samples)
    reports: list[Progress] = []
    network = train(
        samples, seed=given.seed, elapsed=_schedule(given.steps, given.minutes or 30.0, reports)
    )
    last = reports[-1]
    metadata = {
        "network": "GG-CNN",
        "data": f"{len(samples)} images of scenes made by app.grasps.generate, seed {given.seed}",
        "training": f"{last.step} steps, final loss {last.loss:.4f}",
        "licence": "Apache-2.0",
    }
    save_network(network, given.out, metadata)
    print(f"{given.out}: {metadata['data']}; {metadata['training']}")


def _samples(images: int, seed: int, path: Path | None) -> Samples:
    if path is not None and path.is_file():
        return Samples.load(path)
    begun = stopwatch()
    scenes = -(-images // VIEWS)
    made = []
    for first in range(0, scenes, _SCENES_AT_ONCE):
        made += generate(min(_SCENES_AT_ONCE, scenes - first), seed, first)
        print(f"{len(made)} of {scenes * VIEWS} images, {stopwatch() - begun:.0f} s", flush=True)
    samples = Samples(made)
    if path is not None:
        samples.save(path)
    return samples


def _schedule(
    steps: int | None, minutes: float, reports: list[Progress]
) -> Callable[[Progress], float]:
    """What `train` asks before every step: how much of it is over."""
    begun = stopwatch()

    def part(progress: Progress) -> float:
        reports[:] = [progress]
        if progress.step % _REPORT_EVERY == 0:
            print(
                f"step {progress.step}, loss {progress.loss:.4f}, {stopwatch() - begun:.0f} s",
                flush=True,
            )
        return progress.step / steps if steps else (stopwatch() - begun) / (60.0 * minutes)

    return part


if __name__ == "__main__":
    main()
