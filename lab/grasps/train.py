"""Train the weights of GG-CNN from scratch: render scenes, label them, train.

One folder contains the shards, a checkpoint of every round and the final weights. The same command
resumes an interrupted training.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import cv2
from pydantic import Field
from rich.console import Console
from rich.progress import track

from config.reader import ConfigError, StrictModel
from lab.grasps.choice import require
from lab.grasps.training_data import shard_count, shard_path, write_shards

if TYPE_CHECKING:
    from lab.grasps.ggcnn_training import RoundReport

Count = Annotated[int, Field(ge=1)]
Seed = Annotated[int, Field(ge=0)]


class Data(StrictModel):
    """The rendered images."""

    images: Count = 16384
    validation_images: Count = 1024  # of other scenes; they decide when training stops
    seed: Seed = 0


class Learning(StrictModel):
    """Length and speed of the training; see `TrainingSettings`."""

    seed: Seed = 0
    rounds: Count = 10
    steps: Count = 200
    batch: Count = 16
    learning_rate: Annotated[float, Field(gt=0.0, le=1.0)] = 2e-3
    patience: Count = 4


class TrainingRecipe(StrictModel):
    """A recipe file; the defaults are that of the shipped weights."""

    data: Data = Data()
    learning: Learning = Learning()


def train_weights(
    recipe: TrainingRecipe, folder: Path, *, workers: int | None, console: Console
) -> Path:
    """Render the missing shards, train or resume, and save the weights.

    A GPU is used if there is one. Returns the weights file. Raises ConfigError: the folder contains
    a training with another recipe, or PyTorch is missing.
    """
    require("torch", "grasp train")
    import torch

    from lab.grasps.ggcnn_training import TrainingSettings, train
    from lab.grasps.torch_networks import GGCNN, save_network

    cv2.setNumThreads(1)
    torch.set_num_threads(1)
    train_on, validate_on = _shards(recipe, folder / "shards", workers, console)
    learning = recipe.learning
    torch.manual_seed(learning.seed)

    def report(report: RoundReport) -> None:
        console.print(
            f"round {report.round} of {learning.rounds}: loss {report.loss:.4f}, validation "
            f"{report.validation:.4f} (best {report.best:.4f})",
            highlight=False,
        )

    try:
        network, validation = train(
            GGCNN(),
            train_on,
            validate_on,
            TrainingSettings(**learning.model_dump()),
            checkpoint=folder / "ggcnn.checkpoint",
            device="cuda" if torch.cuda.is_available() else "cpu",
            report=report,
        )
    except ValueError as error:
        raise ConfigError(str(error)) from error
    out = folder / "ggcnn.safetensors"
    metadata = {
        "recipe": recipe.model_dump(),
        "validation_loss": validation,
        "licence": "Apache-2.0",
    }
    save_network(network, out, metadata)
    return out


def _shards(
    recipe: TrainingRecipe, folder: Path, workers: int | None, console: Console
) -> tuple[list[Path], list[Path]]:
    training = shard_count(recipe.data.images)
    total = training + shard_count(recipe.data.validation_images)
    seed = recipe.data.seed
    paths = [shard_path(folder, seed, number) for number in range(total)]
    if missing := sum(not path.is_file() for path in paths):
        new = write_shards(folder, total, seed, workers)
        for _ in track(new, "rendering", total=missing, console=console):
            pass
    return paths[:training], paths[training:]
