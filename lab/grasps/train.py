"""Train the weights of a network from scratch: render scenes, label them, train, evaluate.

One folder contains the shards, a checkpoint of every round and the final weights. The same command
resumes an interrupted training.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import cv2
from rich.console import Console
from rich.progress import track

from config import ConfigError
from lab.grasps.images import CATEGORIES, evaluate_images, valid_rate
from lab.grasps.recipe import TrainingRecipe
from lab.grasps.scenes import ROBOT
from lab.grasps.training_data import shard_count, shard_path, write_shards
from perception import GraspDetector

if TYPE_CHECKING:
    from perception.networks import RoundReport

EVALUATED = 200
"""Images of each category on which new weights are evaluated, for the metadata of their file."""

Item = TypeVar("Item")


def train_weights(
    recipe: TrainingRecipe, folder: Path, *, workers: int, device: str, console: Console
) -> Path:
    """Render the missing shards, train or resume, and save the weights.

    Args:
        recipe: network, data and settings.
        folder: of the training; recipes may share its `shards/`.
        workers: number of processes that render.
        device: of PyTorch; `auto` is a GPU if there is one.
        console: for progress.

    Returns:
        The weights file, with the recipe and the valid rates in its metadata.

    Raises:
        ConfigError: the folder contains a training with another recipe.
    """
    import torch

    from perception.networks import NETWORKS, TrainingSettings, save_network, train

    cv2.setNumThreads(1)
    torch.set_num_threads(1)
    if device == "auto":
        device = "cuda" if torch.cuda.is_available() else "cpu"
    train_on, validate_on = _shards(recipe, folder / "shards", workers, console)
    torch.manual_seed(recipe.learning.seed)
    learning = recipe.learning

    def report(report: RoundReport) -> None:
        console.print(
            f"round {report.round} of {learning.rounds}: loss {report.loss:.4f}, validation "
            f"{report.validation:.4f} (best {report.best:.4f})",
            highlight=False,
        )

    try:
        network, validation = train(
            NETWORKS[recipe.network](),
            train_on,
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
    detector = GraspDetector(out, gripper=ROBOT.gripper)
    valid_rates = {
        category: valid_rate(evaluate_images(detector, category, range(EVALUATED)))
        for category in CATEGORIES
    }
    metadata = {
        "recipe": recipe.model_dump(),
        "validation_loss": validation,
        "valid_of_unseen": valid_rates,
        "licence": "Apache-2.0",
    }
    save_network(network, out, metadata)
    return out


def _shards(
    recipe: TrainingRecipe, folder: Path, workers: int, console: Console
) -> tuple[list[Path], list[Path]]:
    training = shard_count(recipe.data.images)
    total = training + shard_count(recipe.data.validation_images)
    seed = recipe.data.seed
    missing = sum(not shard_path(folder, seed, n).is_file() for n in range(total))
    for _ in _with_bar(write_shards(folder, total, seed, workers), missing, "rendering", console):
        pass
    paths = [shard_path(folder, seed, number) for number in range(total)]
    return paths[:training], paths[training:]


def _with_bar(items: Iterable[Item], total: int, what: str, console: Console) -> Iterator[Item]:
    if total:
        yield from track(items, what, total=total, console=console)
