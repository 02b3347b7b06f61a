"""Schema of a scene file, in metres, with the robot at the origin of the world at the start."""

from __future__ import annotations

from itertools import pairwise
from math import cos, hypot, radians, sin
from pathlib import Path
from typing import Annotated, ClassVar, NamedTuple, TypeVar

from pydantic import AfterValidator, Field, ValidationInfo, field_validator, model_validator

from config import UserError, suggest
from config.planar import rotate
from config.reader import StrictModel
from hw.sim.meshes import MeshError, Units, Up, read_mesh
from hw.sim.objects import HOUSEHOLD, OBJECT_CLASSES
from hw.sim.sim_object import Mesh
from perception import ColourName


class SceneError(UserError):
    """A scene that cannot be found, read or filled."""


def _at_most(most: float) -> AfterValidator:
    """Of a length [m]; a larger one may have been meant in millimetres."""

    def check(length: float) -> float:
        if abs(length) > most:
            is_other = abs(length) >= 100.0 and abs(length) / 1000.0 <= most
            hint = f"did you mean {length / 1000.0:g}?" if is_other else "lengths are in metres"
            raise ValueError(f"is {length:g} m, and {most:g} m are possible; {hint}")
        return length

    return AfterValidator(check)


def _valid_name(name: str) -> str:
    if not name.strip() or not name.isprintable() or "/" in name or len(name) > 60:
        raise ValueError("is no name; write at most 60 characters of text without `/`")
    if name in _RESERVED:
        raise ValueError("is the name of other furniture: choose another one")
    return name


def _class_name(kind: str) -> str:
    if kind not in OBJECT_CLASSES:
        raise ValueError(f"no kind of object is called `{kind}`; {suggest(kind, OBJECT_CLASSES)}")
    return kind


_T = TypeVar("_T")


def _limited(items: tuple[_T, ...]) -> tuple[_T, ...]:
    if len(items) > _MAX_COUNT:
        raise ValueError(f"are {len(items)}, and {_MAX_COUNT} are possible; leave some out")
    return items


_HEAD = 1.2  # below this height nothing stands over the footprint of the folded robot [m]
_MAX_COUNT = 100  # of side tables, of fixtures, and of walkers
_RESERVED = ("container", "floor", "hand", "pedestal", "table")

Length = Annotated[float, Field(gt=0.0), _at_most(10.0)]
Coordinate = Annotated[float, _at_most(50.0)]
Degrees = Annotated[float, Field(ge=-360.0, le=360.0)]
Name = Annotated[str, AfterValidator(_valid_name)]
Limited = Annotated[tuple[_T, ...], AfterValidator(_limited)]
_Millimetres = Annotated[float, Field(gt=0.0, le=1000.0)]
_Grams = Annotated[float, Field(gt=0.0, le=100_000.0)]
_Rectangle = tuple[tuple[float, float], tuple[float, float], float]
"""Centre and full size along its own axes [m], and yaw [rad], seen from above."""

Footprint = tuple[float, float]  # of the robot along x and y, where it starts [m]


class ReadingContext(NamedTuple):
    """The validation context of a scene file."""

    folder: Path  # of the scene file: paths of meshes are relative to it
    footprint: Footprint | None  # None: furniture may stand where the robot starts


class MeshFile(StrictModel):
    """A body that may be given by a mesh file; validation makes its path absolute."""

    SIZES: ClassVar[tuple[float, float]] = (0.01, 10.0)  # range of the longest edge [m]

    units: Units = "m"  # of the numbers in the file
    scale: Annotated[float, Field(ge=1e-6, le=1e6)] = 1.0
    up: Up | None = None  # axis of the file that points upwards; None: z, and y in a GLB file
    mesh: str | None = None  # path of a GLB, OBJ, OFF, PLY or STL file

    @field_validator("mesh")
    @classmethod
    def _can_be_used(cls, mesh: str | None, info: ValidationInfo) -> str | None:
        if mesh is None or not {"units", "scale", "up"} <= set(info.data):
            return mesh
        if not mesh.isprintable() or not Path(mesh).name:
            raise ValueError("is no name of a file; write the path of a mesh")
        folder = info.context.folder if info.context else Path()
        path = str(folder / mesh)
        try:
            read_mesh(path, info.data["units"], info.data["scale"], info.data["up"], cls.SIZES)
        except MeshError as error:
            raise ValueError(f"{Path(mesh).name}: {error}") from error
        return path

    def read(self) -> Mesh:
        """The surface, its middle at the origin [m]; MeshError: the file has changed."""
        assert self.mesh is not None
        return read_mesh(self.mesh, self.units, self.scale, self.up, self.SIZES)


class _Furniture(StrictModel):
    """Does not overlap with the footprint of the robot at its start."""

    @model_validator(mode="after")
    def _is_beside_the_robot(self, info: ValidationInfo) -> _Furniture:
        footprint = info.context.footprint if info.context else None
        if footprint is not None and self._low() < _HEAD and self._overlaps(footprint):
            raise ValueError("it stands where the robot starts; move it away from [0, 0]")
        return self

    def _low(self) -> float:
        """Height of its lowest point above the floor [m]."""
        return 0.0

    def _outline(self) -> _Rectangle:
        raise NotImplementedError

    def _overlaps(self, footprint: Footprint) -> bool:
        """Whether two rectangles overlap: no side of either separates them."""
        (x, y), (wide, deep), yaw = self._outline()
        c, s = abs(cos(yaw)), abs(sin(yaw))
        along, across = rotate(-yaw, x, y)
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
    inner_size: tuple[Length, Length] = (0.44, 0.36)
    floor_height: Length = 0.456  # of the surface below the objects
    wall_height: Length = 0.05
    wall_thickness: Length = 0.006

    def _outline(self) -> _Rectangle:
        wide, deep = (size + 2.0 * self.wall_thickness for size in self.inner_size)
        return self.centre, (wide, deep), 0.0


class Table(_Furniture):
    """A table with four legs."""

    centre: tuple[Coordinate, Coordinate]
    size: tuple[Length, Length] = (1.2, 0.6)
    height: Length = 0.5  # of the top side

    def _outline(self) -> _Rectangle:
        return self.centre, self.size, 0.0


class Item(MeshFile):
    """One object with given properties; those that are None are drawn at random."""

    SIZES: ClassVar[tuple[float, float]] = (0.01, 0.6)

    kind: Annotated[str, AfterValidator(_class_name)] | None = None
    mass_g: _Grams | None = None
    colour: ColourName | None = None
    friction: Annotated[float, Field(ge=0.05, le=3.0)] | None = None  # with the finger pads
    at: tuple[Coordinate, Coordinate] | None = None  # middle of its bounding box
    yaw_deg: Degrees | None = None  # 0 if `at` is given

    @model_validator(mode="after")
    def _is_class_or_mesh(self) -> Item:
        if (self.kind is None) == (self.mesh is None):
            raise ValueError("is of no kind and no mesh, or of both; write `kind` or `mesh`")
        return self


class Objects(StrictModel):
    """The objects in the container, on a table or on a fixture."""

    items: Limited[Item] = ()
    count: Annotated[int, Field(ge=0, le=40)] = 10  # random ones; if not given, with items none
    kinds: tuple[str, ...] = tuple(HOUSEHOLD)
    width_mm: tuple[_Millimetres, _Millimetres] = (15.0, 70.0)  # smallest width across the grasp
    mass_g: tuple[_Grams, _Grams] = (30.0, 500.0)

    @field_validator("kinds")
    @classmethod
    def _known(cls, kinds: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(_class_name(kind) for kind in kinds)

    @field_validator("width_mm", "mass_g")
    @classmethod
    def _ascending(cls, bounds: tuple[float, float]) -> tuple[float, float]:
        if bounds[0] > bounds[1]:
            raise ValueError("must be the smallest, then the largest")
        return bounds

    @property
    def random_count(self) -> int:
        """How many objects are drawn at random."""
        return self.count if "count" in self.model_fields_set or not self.items else 0


class Motion(StrictModel):
    """Motion of the objects on a table: along a line, back and forth."""

    along: tuple[Coordinate, Coordinate]  # from one end of the line to the other
    period_s: Annotated[float, Field(ge=0.1, le=1e6)]  # there and back
    stop_s: Annotated[float, Field(ge=0.0, le=1e9)] | None = None  # time at which they stop
    steady: bool = False  # constant speed, as on a belt; else sinusoidal


class SideTable(Table):
    """Another table, with objects anywhere on it."""

    name: Name
    objects: Objects
    motion: Motion | None = None


class Fixture(_Furniture, MeshFile):
    """A static box or mesh."""

    name: Name
    centre: tuple[Coordinate, Coordinate, Coordinate]  # of its bounding box
    size: tuple[Length, Length, Length] | None = None  # of a box
    yaw_deg: Degrees = 0.0
    on_map: bool = True  # whether the robot's map contains it
    objects: Objects | None = None  # on the top of a box, as on a counter or a board of a shelf

    @model_validator(mode="after")
    def _is_box_or_mesh(self) -> Fixture:
        if (self.size is None) == (self.mesh is None):
            raise ValueError("is neither a box nor a mesh, or both; write `size` or `mesh`")
        return self

    @field_validator("objects")
    @classmethod
    def _lie_on_a_straight_box(
        cls, objects: Objects | None, info: ValidationInfo
    ) -> Objects | None:
        if info.data.get("mesh") or info.data.get("yaw_deg"):
            raise ValueError("lie on boxes along x and y only; use `size`, without `yaw_deg`")
        return objects

    def _edges(self) -> tuple[float, float, float]:
        """Of its bounding box before it is turned [m]."""
        if self.size is not None:
            return self.size
        x, y, z = self.read().half if self.mesh else (0.0, 0.0, 0.0)
        return 2.0 * x, 2.0 * y, 2.0 * z

    def _low(self) -> float:
        return self.centre[2] - self._edges()[2] / 2.0

    def _outline(self) -> _Rectangle:
        return self.centre[:2], self._edges()[:2], radians(self.yaw_deg)


class Walker(_Furniture):
    """A moving obstacle: an upright cylinder that walks to and fro between way points."""

    name: Name
    radius: Annotated[float, Field(ge=0.02, le=2.0)] = 0.25
    height: Annotated[float, Field(ge=0.1, le=5.0)] = 1.75
    way: Annotated[tuple[tuple[Coordinate, Coordinate], ...], Field(min_length=2, max_length=100)]
    speed: Annotated[float, Field(ge=0.01, le=3.0)] = 1.0  # [m/s]

    @field_validator("way")
    @classmethod
    def _has_distinct_points(
        cls, way: tuple[tuple[float, float], ...]
    ) -> tuple[tuple[float, float], ...]:
        if any(hypot(x - u, y - v) < 0.01 for (x, y), (u, v) in pairwise(way)):
            raise ValueError("two points in a row are the same; leave one out")
        return way

    def _outline(self) -> _Rectangle:
        return self.way[0], (2.0 * self.radius, 2.0 * self.radius), 0.0
