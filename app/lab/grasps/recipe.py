"""Recipes: YAML files that say how weights are made, from the first scene to the last step."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from config import ConfigError, StrictModel, read_config, suggest

RECIPES = Path(__file__).parent / "recipes"
"""Where the shipped recipes lie."""

Count = Annotated[int, Field(ge=1)]
Seed = Annotated[int, Field(ge=0)]


class Data(StrictModel):
    """What is learnt from."""

    images: Count = 16384
    validation_images: Count = 1024
    """Of other scenes; they decide when learning ends."""
    seed: Seed = 0


class Learning(StrictModel):
    """How long and how fast; see `perception.networks.training.Recipe`."""

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
    """A shipped recipe, or one's own.

    Args:
        name: of a shipped recipe, or path of a file.

    Raises:
        ConfigError: there is none, or it is not a good one.
    """
    path = Path(name)
    if not path.is_file():
        path = RECIPES / f"{name}.yaml"
    if not path.is_file():
        names = sorted(each.stem for each in RECIPES.glob("*.yaml"))
        raise ConfigError(
            f"no recipe is called `{name}`; {suggest(name, names)} A file will do too"
        )
    return read_config(path, TrainingRecipe)
