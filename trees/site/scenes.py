"""Scenes: those that tasks name, and files that are one."""

from __future__ import annotations

from os.path import isfile
from pathlib import Path

from config import Diagnostics, YamlMap, read_yaml
from trees.language import Task


def is_scene(path: Path) -> bool:
    """Whether a file is a scene: it has keys of one, and none that a task needs."""
    read = read_yaml(Diagnostics(path))
    if read is None or not isinstance(read[1], YamlMap):
        return False
    keys = set(read[1].entries)
    if keys & {"task", "tree"}:
        return False
    from hw.sim import Scene

    return bool(keys & set(Scene.model_fields) - {"description"})


def scene_of(task: Task) -> str:
    """The scene that a task names: a path if the file is beside it, else as it is; or empty."""
    beside = task.path.parent / Path(task.scene)
    return str(beside) if task.scene and isfile(beside) else task.scene
