"""Scene files: YAML that describes furniture and objects."""

from __future__ import annotations

from collections.abc import Sequence
from os.path import isfile
from pathlib import Path
from typing import Annotated, TypeVar

from pydantic import AfterValidator, field_validator

from config import (
    ConfigError,
    Diagnostics,
    Location,
    StrictModel,
    UserError,
    YamlList,
    YamlMap,
    YamlValue,
    quoted,
    read_config,
    read_yaml,
    suggest,
)
from hw.sim.furniture import Container, Fixture, Objects, SideTable, Table, Walker, few
from hw.sim.mesh_file import Footprint, Reading

SCENES = Path(__file__).parent / "scenes"  # The folder of the shipped scenes

_Named = TypeVar("_Named", SideTable, Walker)


class SceneError(UserError):
    """A scene that cannot be found, read or filled."""


class Scene(StrictModel):
    """A scene file."""

    description: str = ""
    container: Container
    table: Table
    side_tables: Annotated[tuple[SideTable, ...], AfterValidator(few)] = ()
    fixtures: Annotated[tuple[Fixture, ...], AfterValidator(few)] = ()
    walkers: Annotated[tuple[Walker, ...], AfterValidator(few)] = ()
    objects: Objects = Objects()  # In the container

    @field_validator("side_tables", "walkers")
    @classmethod
    def _are_told_apart(cls, items: tuple[_Named, ...]) -> tuple[_Named, ...]:
        names = [item.name for item in items]
        if twice := {name for name in names if names.count(name) > 1}:
            raise ValueError(f"two of them are called {quoted(sorted(twice))}; rename one")
        return items


def scene_names() -> list[str]:
    """Names of the shipped scenes."""
    return sorted(path.stem for path in SCENES.glob("*.yaml"))


def read_scene(scene: str | Path, footprint: Footprint | None = None) -> Scene:
    """Read and check a scene file.

    Args:
        scene: name of a shipped scene, or path of a scene file.
        footprint: of the robot that starts in it; None leaves the start unchecked.

    Raises:
        SceneError: there is no such scene, or its file is not valid.
    """
    try:
        path = find_scene(scene)
        return read_config(path, Scene, context=Reading(path.parent, footprint))
    except ConfigError as error:
        raise SceneError(str(error)) from error


def place(scene: str | Path, keys: Sequence[str | int]) -> str:
    """Where a scene file says something, as `file:line:column`.

    Args:
        scene: name of a shipped scene, or path of a scene file.
        keys: on the way to it; those that the file leaves out are passed over.
    """
    path = find_scene(scene)
    read = read_yaml(Diagnostics(path))
    if read is None:
        return str(path)
    location = location_of(read[1], keys)
    return f"{path}:{location.line}:{location.column}"


def location_of(value: YamlValue, keys: Sequence[str | int]) -> Location:
    """Where a file says something; keys that it leaves out are passed over."""
    location = value.location
    for key in keys:
        if isinstance(value, YamlMap) and key in value.entries:
            location, value = value.entries[str(key)].location, value.entries[str(key)].value
        elif isinstance(value, YamlList) and isinstance(key, int) and key < len(value.items):
            value = value.items[key]
            location = value.location
    return location


def find_scene(scene: str | Path) -> Path:
    """The file of a scene that is given by path or name.

    Raises:
        SceneError: it is neither.
    """
    path = Path(scene)
    if isfile(path):
        return path
    shipped = SCENES / f"{scene}.yaml"
    if isfile(shipped):
        return shipped
    names = scene_names()
    raise SceneError(
        f"no scene is called `{scene}`; {suggest(str(scene), names)} "
        f"The shipped scenes are {quoted(names)}; the path of a scene file works too"
    )
