"""docs/scenes.md says what a scene file may say."""

import re
from pathlib import Path

import pytest

from config import StrictModel
from hw.sim import load_scene, read_scene, scene_names
from hw.sim.scene import Scene
from hw.sim.scene_schema import Container, Fixture, Item, Motion, Objects, SideTable, Table, Walker

PAGE = (Path(__file__).parents[2] / "docs" / "scenes.md").read_text(encoding="utf-8")
MODELS = (Scene, Container, Table, SideTable, Objects, Item, Motion, Fixture, Walker)


def test_its_example_is_a_scene(tmp_path):
    example = re.findall(r"```yaml\n(.*?)```", PAGE, flags=re.DOTALL)[0]
    path = tmp_path / "workshop.yaml"
    path.write_text(example)
    assert read_scene(path, (0.7, 0.5)).walkers[0].name == "Ada"
    assert len(load_scene(path, 0).objects) == 6


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.__name__)
def test_every_key_is_explained(model: type[StrictModel]):
    missing = [key for key in model.model_fields if f"`{key}`" not in PAGE]
    assert missing == []


def test_every_shipped_scene_is_listed():
    assert [name for name in scene_names() if f"`{name}`" not in PAGE] == []
