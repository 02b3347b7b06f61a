"""Make a network's weights from nothing: render scenes, label them, learn, judge.

Everything lies in one folder: the shards, a checkpoint after every round, and the weights at the
end. The same command goes on where an interrupted one stopped.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TypeVar

import cv2
import torch
from rich.console import Console
from rich.progress import track

from app.lab.grasps.generate import shard_path, shards_of, write_shards
from app.lab.grasps.images import judge_images, valid_rate
from app.lab.grasps.recipe import TrainingRecipe
from config import ConfigError
from perception import GraspDetector
from perception.networks.training import RoundReport, TrainingSettings, train
from perception.networks.weights import NETWORKS, save_network

JUDGED = 200
"""Images of each category that new weights are judged on, for the story in their file."""

Item = TypeVar("Item")


def make_weights(
    recipe: TrainingRecipe, folder: Path, *, workers: int, device: str, console: Console
) -> Path:
    """Render what is missing, learn what is left, and save what comes of it.

    Args:
        recipe: how.
        folder: where everything lies; shards in `shards/`, so that recipes may share them.
        workers: processes that render.
        device: of PyTorch; `auto` takes a GPU if there is one.
        console: for progress.

    Returns:
        The file of weights, with the recipe and how good they are in its metadata.

    Raises:
        ConfigError: the folder holds a training of another recipe.
    """
    cv2.setNumThreads(1)
    torch.set_num_threads(1)
    if device == "auto":
        device = "cuda" if torch.cuda.is_available() else "cpu"
    learn_from, validate_on = _shards(recipe, folder / "shards", workers, console)
    torch.manual_seed(recipe.learning.seed)
    learning = recipe.learning

    def report(report: RoundReport) -> None:
        console.print(
            f"round {report.round} of {learning.rounds}: loss {report.loss:.4f}, on unseen scenes "
            f"{report.validation:.4f} (best {report.best:.4f})",
            highlight=False,
        )

    try:
        network, validation = train(
            NETWORKS[recipe.network](),
            learn_from,
            validate_on,
            TrainingSettings(**learning.model_dump()),
            checkpoint=folder / f"{recipe.network}.checkpoint",
            device=device,
            report=report,
        )
    except ValueError as error:
        raise ConfigError(str(error)) from error
    out = folder / f"{recipe.network}.safetensors"
    save_network(network, out, {"recipe": recipe.model_dump()})
    detector = GraspDetector(out)
    judged = {
        category: valid_rate(judge_images(detector, category, range(JUDGED)))
        for category in ("single", "clutter")
    }
    story = {
        "recipe": recipe.model_dump(),
        "validation_loss": validation,
        "valid_of_unseen": judged,
        "licence": "Apache-2.0",
    }
    save_network(network, out, story)
    return out


def _shards(
    recipe: TrainingRecipe, folder: Path, workers: int, console: Console
) -> tuple[list[Path], list[Path]]:
    learn, validate = shards_of(recipe.data.images), shards_of(recipe.data.validation_images)
    total, seed = learn + validate, recipe.data.seed
    missing = sum(not shard_path(folder, seed, n).is_file() for n in range(total))
    for _ in _told(write_shards(folder, total, seed, workers), missing, "rendering", console):
        pass
    paths = [shard_path(folder, seed, number) for number in range(total)]
    return paths[:learn], paths[learn:]


def _told(items: Iterable[Item], total: int, what: str, console: Console) -> Iterator[Item]:
    if total:
        yield from track(items, what, total=total, console=console)
