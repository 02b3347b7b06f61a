"""Scenes: YAML files that say what stands where."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from hw.sim.household import KINDS

SCENES = Path(__file__).parent / "scenes"
"""Where the shipped scenes lie."""

Length = Annotated[float, Field(gt=0.0, le=10.0)]
Coordinate = Annotated[float, Field(ge=-50.0, le=50.0)]


class SceneError(Exception):
    """A scene cannot be found, read or filled; the text says what, where and how to mend it."""


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Container(_Strict):
    """An open box on a pedestal."""

    centre: tuple[Coordinate, Coordinate]
    """x, y in the world [m]."""
    inner_size: tuple[Length, Length] = (0.44, 0.36)
    """Along x and y [m]."""
    floor_height: Length = 0.456
    """Of what the objects lie on [m]."""
    wall_height: Length = 0.05
    """[m]."""
    wall_thickness: Length = 0.006
    """[m]."""


class Table(_Strict):
    """A table with four legs."""

    centre: tuple[Coordinate, Coordinate]
    """x, y in the world [m]."""
    size: tuple[Length, Length] = (1.2, 0.6)
    """Along x and y [m]."""
    height: Length = 0.5
    """Of the top side [m]."""


class Fixture(_Strict):
    """A box that never moves."""

    name: Annotated[str, Field(min_length=1)]
    centre: tuple[Coordinate, Coordinate, Coordinate]
    """x, y, z in the world [m]."""
    size: tuple[Length, Length, Length]
    """Full edge lengths [m]."""
    yaw_deg: float = 0.0


class Objects(_Strict):
    """The objects in the container, or on a table."""

    count: Annotated[int, Field(ge=0, le=40)] = 10
    kinds: tuple[str, ...] = tuple(KINDS)
    width_mm: tuple[float, float] = (15.0, 70.0)
    """Range of the smallest width by which they can be grasped."""
    mass_g: tuple[float, float] = (30.0, 500.0)

    @field_validator("kinds")
    @classmethod
    def _known(cls, kinds: tuple[str, ...]) -> tuple[str, ...]:
        for kind in kinds:
            if kind not in KINDS:
                raise ValueError(f"no kind of object {kind!r}{_instead(kind, KINDS)}")
        return kinds

    @field_validator("width_mm", "mass_g")
    @classmethod
    def _ascending(cls, bounds: tuple[float, float]) -> tuple[float, float]:
        if not 0.0 < bounds[0] <= bounds[1]:
            raise ValueError("give the smallest first, then the largest, both above 0")
        return bounds


class Motion(_Strict):
    """How the objects of a table move by themselves: along a line, to and fro."""

    along: tuple[Coordinate, Coordinate]
    """x, y from one end of the way to the other [m]."""
    period_s: Annotated[float, Field(gt=0.0)]
    """For the way there and back [s]."""
    stop_s: Annotated[float, Field(ge=0.0)] | None = None
    """Simulated time from which they stand still [s]; without it they never do."""


_TAKEN = ("container", "floor", "pedestal", "table")
"""Names of what every scene has."""


class SideTable(Table):
    """A further table, with objects anywhere on it."""

    name: Annotated[str, Field(pattern=r"^[^/]+$")]
    objects: Objects
    motion: Motion | None = None

    @field_validator("name")
    @classmethod
    def _free(cls, name: str) -> str:
        if name in _TAKEN:
            raise ValueError("is the name of other furniture: choose another one")
        return name


class Scene(_Strict):
    """A scene file."""

    description: str = ""
    container: Container
    table: Table
    side_tables: tuple[SideTable, ...] = ()
    fixtures: tuple[Fixture, ...] = ()
    objects: Objects = Objects()
    """In the container."""


def scene_names() -> list[str]:
    """Names of the shipped scenes."""
    return sorted(path.stem for path in SCENES.glob("*.yaml"))


def read_scene(scene: str | Path) -> Scene:
    """A scene file, checked.

    Args:
        scene: name of a shipped scene, or path of a scene file.

    Raises:
        SceneError: there is no such scene, or it says something that a scene cannot be.
    """
    path = _find(scene)
    try:
        text = path.read_text(encoding="utf-8")
        node = yaml.compose(text, Loader=yaml.SafeLoader)
        return Scene.model_validate(yaml.safe_load(text))
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"{path}: cannot be read: {error}") from error
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"{mark.line + 1}:{mark.column + 1}" if mark else "1:1"
        raise SceneError(f"{path}:{where}: not YAML: {error.problem}") from error
    except yaml.YAMLError as error:
        raise SceneError(f"{path}: not YAML: {str(error).splitlines()[0]}") from error
    except ValidationError as error:
        raise SceneError(f"{path}:{_explain(node, error.errors()[0])}") from error


def _find(scene: str | Path) -> Path:
    path = Path(scene)
    if path.is_file():
        return path
    shipped = SCENES / f"{scene}.yaml"
    if shipped.is_file():
        return shipped
    names = scene_names()
    close = difflib.get_close_matches(str(scene), names, n=1)
    hint = f": did you mean {close[0]!r}?" if close else "."
    raise SceneError(
        f"no scene {str(scene)!r}{hint} Shipped are {', '.join(names)}; "
        "the path of a scene file will do too"
    )


def _explain(root: yaml.Node | None, error: Any) -> str:
    """One line for what pydantic objects to: where it stands, what is wrong, how to mend it."""
    location, kind = error["loc"], error["type"]
    line, column, holder = _locate(root, location)
    where = f"{line}:{column}: {'.'.join(str(key) for key in location) or 'scene'}"
    if kind == "extra_forbidden":
        return f"{where}: unknown key{_instead(str(location[-1]), _fields(location[:-1]))}"
    if kind == "missing":
        return f"{where}: is missing: add it under {holder}"
    message = error["msg"].removeprefix("Value error, ")
    given = "" if isinstance(error["input"], dict) else f", not {error['input']!r}"
    return f"{where}: {message[:1].lower()}{message[1:]}{given}"


def _locate(root: yaml.Node | None, location: tuple[int | str, ...]) -> tuple[int, int, str]:
    """Line and column of the deepest node on the way to a location, and that node's key."""
    node, mark, holder = root, root.start_mark if root else None, "the top level"
    for key in location:
        if isinstance(node, yaml.MappingNode):
            found = next((entry for entry in node.value if entry[0].value == key), None)
            if found is None:
                break
            mark, node, holder = found[0].start_mark, found[1], str(key)
        elif isinstance(node, yaml.SequenceNode) and isinstance(key, int) and key < len(node.value):
            node = node.value[key]
            mark = node.start_mark
    return (mark.line + 1, mark.column + 1, holder) if mark else (1, 1, holder)


def _fields(location: tuple[int | str, ...]) -> list[str]:
    """The keys that are known at a location."""
    keys = [key for key in location if isinstance(key, str)]
    model = _MODELS[keys[-1]] if keys else Scene
    return list(model.model_fields)


_MODELS: dict[str, type[_Strict]] = {
    "container": Container,
    "table": Table,
    "side_tables": SideTable,
    "motion": Motion,
    "fixtures": Fixture,
    "objects": Objects,
}


def _instead(word: str, known: Iterable[str]) -> str:
    words = list(known)
    close = difflib.get_close_matches(word, words, n=1)
    return f": did you mean {close[0]!r}?" if close else f": known are {', '.join(words)}"
