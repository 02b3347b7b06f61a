"""Scene files: YAML that describes furniture and objects."""

from __future__ import annotations

from os.path import isfile
from pathlib import Path
from typing import Annotated

from pydantic import Field, field_validator

from config import ConfigError, StrictModel, UserError, quoted, read_config, suggest
from hw.sim.objects import HOUSEHOLD, OBJECT_CLASSES

SCENES = Path(__file__).parent / "scenes"
"""The folder of the shipped scenes."""

Length = Annotated[float, Field(gt=0.0, le=10.0)]
Coordinate = Annotated[float, Field(ge=-50.0, le=50.0)]


class SceneError(UserError):
    """A scene that cannot be found, read or filled."""


class Container(StrictModel):
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


class Table(StrictModel):
    """A table with four legs."""

    centre: tuple[Coordinate, Coordinate]
    """x, y in the world [m]."""
    size: tuple[Length, Length] = (1.2, 0.6)
    """Along x and y [m]."""
    height: Length = 0.5
    """Of the top side [m]."""


class Fixture(StrictModel):
    """A box that never moves."""

    name: Annotated[str, Field(min_length=1)]
    centre: tuple[Coordinate, Coordinate, Coordinate]
    """x, y, z in the world [m]."""
    size: tuple[Length, Length, Length]
    """Full edge lengths [m]."""
    yaw_deg: float = 0.0


class Objects(StrictModel):
    """The objects in the container, or on a table."""

    count: Annotated[int, Field(ge=0, le=40)] = 10
    kinds: tuple[str, ...] = tuple(HOUSEHOLD)
    width_mm: tuple[float, float] = (15.0, 70.0)
    """Range of the smallest width by which they can be grasped [mm]."""
    mass_g: tuple[float, float] = (30.0, 500.0)
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
        if not 0.0 < bounds[0] <= bounds[1]:
            raise ValueError("must be the smallest, then the largest, both above 0")
        return bounds


class Motion(StrictModel):
    """How the objects on a table move by themselves: along a line, back and forth."""

    along: tuple[Coordinate, Coordinate]
    """x, y from one end of the line to the other [m]."""
    period_s: Annotated[float, Field(gt=0.0)]
    """From one end to the other and back [s]."""
    stop_s: Annotated[float, Field(ge=0.0)] | None = None
    """Simulated time from which they stand still [s]; without it they never stop."""


_RESERVED = ("container", "floor", "pedestal", "table")
"""Names of the furniture of every scene."""


class SideTable(Table):
    """Another table, with objects anywhere on it."""

    name: Annotated[str, Field(pattern=r"^[^/]+$")]
    objects: Objects
    motion: Motion | None = None

    @field_validator("name")
    @classmethod
    def _is_free(cls, name: str) -> str:
        if name in _RESERVED:
            raise ValueError("is the name of other furniture: choose another one")
        return name


class Scene(StrictModel):
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
    """Read and check a scene file.

    Args:
        scene: name of a shipped scene, or path of a scene file.

    Raises:
        SceneError: there is no such scene, or its file is not valid.
    """
    try:
        return read_config(_find(scene), Scene)
    except ConfigError as error:
        raise SceneError(str(error)) from error


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
