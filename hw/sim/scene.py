"""Scene files: YAML that describes furniture and objects."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, radians, sin
from os.path import isfile
from pathlib import Path
from typing import Annotated, TypeVar

from pydantic import AfterValidator, Field, ValidationInfo, field_validator, model_validator

from config import (
    ConfigError,
    Diagnostics,
    StrictModel,
    UserError,
    YamlList,
    YamlMap,
    quoted,
    read_config,
    read_yaml,
    suggest,
)
from hw.sim.objects import HOUSEHOLD, OBJECT_CLASSES

SCENES = Path(__file__).parent / "scenes"
"""The folder of the shipped scenes."""

Length = Annotated[float, Field(gt=0.0, le=10.0)]
Coordinate = Annotated[float, Field(ge=-50.0, le=50.0)]
Footprint = tuple[float, float]
"""Of the robot along x and y, where it starts: at the origin, with heading 0 [m]."""

_HEAD = 1.2
"""Below this height nothing stands over the footprint; the folded arm is there [m]."""
_MOST = 100
"""Of side tables, and of fixtures."""
_RESERVED = ("container", "floor", "hand", "pedestal", "table")
"""Names of the furniture of every scene, and of what holds objects besides."""
_Item = TypeVar("_Item")


def _line_of_text(name: str) -> str:
    if not name.strip() or not name.isprintable() or "/" in name or len(name) > 60:
        raise ValueError("is no name; write at most 60 characters of text without `/`")
    if name in _RESERVED:
        raise ValueError("is the name of other furniture: choose another one")
    return name


def _few(items: tuple[_Item, ...]) -> tuple[_Item, ...]:
    if len(items) > _MOST:
        raise ValueError(f"are {len(items)}, and {_MOST} are possible; leave some out")
    return items


Name = Annotated[str, AfterValidator(_line_of_text)]


class SceneError(UserError):
    """A scene that cannot be found, read or filled."""


class _Furniture(StrictModel):
    """Does not stand where the robot starts; its footprint is the context of the validation."""

    @model_validator(mode="after")
    def _is_beside_the_robot(self, info: ValidationInfo) -> _Furniture:
        if info.context is not None and self.low < _HEAD and self._overlaps(info.context):
            raise ValueError("it stands where the robot starts; move it away from [0, 0]")
        return self

    @property
    def low(self) -> float:
        """Height of its lowest point above the floor [m]; all that is not a box has feet."""
        return 0.0

    @property
    def outline(self) -> tuple[tuple[float, float], tuple[float, float], float]:
        """Centre and full size along its own axes [m], and yaw [rad], seen from above."""
        raise NotImplementedError

    def _overlaps(self, footprint: Footprint) -> bool:
        """Whether two rectangles overlap: no side of either separates them."""
        (x, y), (wide, deep), yaw = self.outline
        c, s = abs(cos(yaw)), abs(sin(yaw))
        along, across = x * cos(yaw) + y * sin(yaw), y * cos(yaw) - x * sin(yaw)
        width, depth = footprint
        return (
            2.0 * abs(x) < width + wide * c + deep * s
            and 2.0 * abs(y) < depth + wide * s + deep * c
            and 2.0 * abs(along) < wide + width * c + depth * s
            and 2.0 * abs(across) < deep + width * s + depth * c
        )


class Container(_Furniture):
    """An open box on a pedestal, with objects in it."""

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

    @property
    def outline(self) -> tuple[tuple[float, float], tuple[float, float], float]:
        """See `_Furniture`."""
        wide, deep = (size + 2.0 * self.wall_thickness for size in self.inner_size)
        return self.centre, (wide, deep), 0.0


class Table(_Furniture):
    """A table with four legs."""

    centre: tuple[Coordinate, Coordinate]
    """x, y in the world [m]."""
    size: tuple[Length, Length] = (1.2, 0.6)
    """Along x and y [m]."""
    height: Length = 0.5
    """Of the top side [m]."""

    @property
    def outline(self) -> tuple[tuple[float, float], tuple[float, float], float]:
        """See `_Furniture`."""
        return self.centre, self.size, 0.0


class Fixture(_Furniture):
    """A box that never moves."""

    name: Name
    centre: tuple[Coordinate, Coordinate, Coordinate]
    """x, y, z in the world [m]."""
    size: tuple[Length, Length, Length]
    """Full edge lengths [m]."""
    yaw_deg: Annotated[float, Field(ge=-360.0, le=360.0)] = 0.0

    @property
    def low(self) -> float:
        """See `_Furniture`."""
        return self.centre[2] - self.size[2] / 2.0

    @property
    def outline(self) -> tuple[tuple[float, float], tuple[float, float], float]:
        """See `_Furniture`."""
        return self.centre[:2], self.size[:2], radians(self.yaw_deg)


_Millimetres = Annotated[float, Field(gt=0.0, le=1000.0)]
_Grams = Annotated[float, Field(gt=0.0, le=100_000.0)]


class Objects(StrictModel):
    """The objects in the container, or on a table."""

    count: Annotated[int, Field(ge=0, le=40)] = 10
    kinds: tuple[str, ...] = tuple(HOUSEHOLD)
    width_mm: tuple[_Millimetres, _Millimetres] = (15.0, 70.0)
    """Range of the smallest width by which they can be grasped [mm]."""
    mass_g: tuple[_Grams, _Grams] = (30.0, 500.0)
    """Range of their mass [g]."""

    @field_validator("kinds")
    @classmethod
    def _known(cls, kinds: tuple[str, ...]) -> tuple[str, ...]:
        for name in kinds:
            if name not in OBJECT_CLASSES:
                raise ValueError(
                    f"no kind of object is called `{name}`; {suggest(name, OBJECT_CLASSES)}"
                )
        return kinds

    @field_validator("width_mm", "mass_g")
    @classmethod
    def _ascending(cls, bounds: tuple[float, float]) -> tuple[float, float]:
        if bounds[0] > bounds[1]:
            raise ValueError("must be the smallest, then the largest")
        return bounds


class Motion(StrictModel):
    """How the objects on a table move by themselves: along a line, back and forth."""

    along: tuple[Coordinate, Coordinate]
    """x, y from one end of the line to the other [m]."""
    period_s: Annotated[float, Field(ge=0.1, le=1e6)]
    """From one end to the other and back [s]."""
    stop_s: Annotated[float, Field(ge=0.0, le=1e9)] | None = None
    """Simulated time from which they stand still [s]; without it they never stop."""


class SideTable(Table):
    """Another table, with objects anywhere on it."""

    name: Name
    objects: Objects
    motion: Motion | None = None


class Scene(StrictModel):
    """A scene file."""

    description: str = ""
    container: Container
    table: Table
    side_tables: Annotated[tuple[SideTable, ...], AfterValidator(_few)] = ()
    fixtures: Annotated[tuple[Fixture, ...], AfterValidator(_few)] = ()
    objects: Objects = Objects()
    """In the container."""

    @field_validator("side_tables")
    @classmethod
    def _are_told_apart(cls, tables: tuple[SideTable, ...]) -> tuple[SideTable, ...]:
        names = [table.name for table in tables]
        if twice := {name for name in names if names.count(name) > 1}:
            raise ValueError(f"two of them are called {quoted(sorted(twice))}; rename one")
        return tables


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
        return read_config(_find(scene), Scene, context=footprint)
    except ConfigError as error:
        raise SceneError(str(error)) from error


def place(scene: str | Path, keys: Sequence[str | int]) -> str:
    """Where a scene file says something, as `file:line:column`.

    Args:
        scene: name of a shipped scene, or path of a scene file.
        keys: on the way to it; those that the file leaves out are passed over.
    """
    path = _find(scene)
    read = read_yaml(Diagnostics(path))
    if read is None:
        return str(path)
    value = read[1]
    location = value.location
    for key in keys:
        if isinstance(value, YamlMap) and key in value.entries:
            location, value = value.entries[str(key)].location, value.entries[str(key)].value
        elif isinstance(value, YamlList) and isinstance(key, int) and key < len(value.items):
            value = value.items[key]
            location = value.location
    return f"{path}:{location.line}:{location.column}"


def _find(scene: str | Path) -> Path:
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
