"""Training recipes: YAML files with the network, the data and the settings of a training."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from config import ConfigError, StrictModel, read_config, suggest

RECIPES = Path(__file__).parent / "recipes"
"""Folder of the shipped recipes."""

Count = Annotated[int, Field(ge=1)]
Seed = Annotated[int, Field(ge=0)]


class Data(StrictModel):
    """The rendered images."""

    images: Count = 16384
    validation_images: Count = 1024
    """Of other scenes; they decide when training stops."""
    seed: Seed = 0


class Learning(StrictModel):
    """Length and speed of the training; see `perception.networks.TrainingSettings`."""

    seed: Seed = 0
    rounds: Count = 16
    steps: Count = 500
    batch: Count = 16
    learning_rate: Annotated[float, Field(gt=0.0, le=1.0)] = 2e-3
    patience: Count = 4


class TrainingRecipe(StrictModel):
    """A recipe file."""

    network: Literal["bins", "ggcnn"]
    data: Data = Data()
    learning: Learning = Learning()


def read_recipe(name: str) -> TrainingRecipe:
    """Read a recipe.

    Args:
        name: of a shipped recipe, or path of a recipe file.

    Raises:
        ConfigError: there is no such recipe, or its file is not valid.
    """
    path = Path(name)
    if not path.is_file():
        path = RECIPES / f"{name}.yaml"
    if not path.is_file():
        names = sorted(each.stem for each in RECIPES.glob("*.yaml"))
        raise ConfigError(
            f"no recipe is called `{name}`; {suggest(name, names)} A recipe file works too"
        )
    return read_config(path, TrainingRecipe)
