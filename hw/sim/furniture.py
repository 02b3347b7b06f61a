"""What stands, lies and walks in a scene, as its file says it."""

from __future__ import annotations

from itertools import pairwise
from math import cos, hypot, radians, sin
from typing import Annotated, ClassVar, TypeVar

from pydantic import AfterValidator, Field, ValidationInfo, field_validator, model_validator

from config import StrictModel, suggest
from hw.sim.mesh_file import Footprint, MeshFile
from hw.sim.objects import HOUSEHOLD, OBJECT_CLASSES
from perception import ColourName


def _at_most(most: float) -> AfterValidator:
    """Of a length [m]; a larger one may have been meant in millimetres."""

    def check(length: float) -> float:
        if abs(length) > most:
            is_other = abs(length) >= 100.0 and abs(length) / 1000.0 <= most
            hint = f"did you mean {length / 1000.0:g}?" if is_other else "lengths are in metres"
            raise ValueError(f"is {length:g} m, and {most:g} m are possible; {hint}")
        return length

    return AfterValidator(check)


Length = Annotated[float, Field(gt=0.0), _at_most(10.0)]
Coordinate = Annotated[float, _at_most(50.0)]
_HEAD = 1.2  # Below this height nothing stands over the footprint; the folded arm is there [m]
_MOST = 100  # Of side tables, of fixtures, and of walkers
_RESERVED = ("container", "floor", "hand", "pedestal", "table")
"""Names of the furniture of every scene, and of what holds objects besides."""
_Item = TypeVar("_Item")


def _line_of_text(name: str) -> str:
    if not name.strip() or not name.isprintable() or "/" in name or len(name) > 60:
        raise ValueError("is no name; write at most 60 characters of text without `/`")
    if name in _RESERVED:
        raise ValueError("is the name of other furniture: choose another one")
    return name


def few(items: tuple[_Item, ...]) -> tuple[_Item, ...]:
    """As many as are possible.

    Raises:
        ValueError: there are more.
    """
    if len(items) > _MOST:
        raise ValueError(f"are {len(items)}, and {_MOST} are possible; leave some out")
    return items


Name = Annotated[str, AfterValidator(_line_of_text)]


class _Furniture(StrictModel):
    """Does not stand where the robot starts; the context of the validation tells its footprint."""

    @model_validator(mode="after")
    def _is_beside_the_robot(self, info: ValidationInfo) -> _Furniture:
        footprint = info.context.footprint if info.context else None
        if footprint is not None and self.low < _HEAD and self._overlaps(footprint):
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

    centre: tuple[Coordinate, Coordinate]  # x, y in the world [m]
    inner_size: tuple[Length, Length] = (0.44, 0.36)  # Along x and y [m]
    floor_height: Length = 0.456  # Of what the objects lie on [m]
    wall_height: Length = 0.05  # [m]
    wall_thickness: Length = 0.006  # [m]

    @property
    def outline(self) -> tuple[tuple[float, float], tuple[float, float], float]:
        """See `_Furniture`."""
        wide, deep = (size + 2.0 * self.wall_thickness for size in self.inner_size)
        return self.centre, (wide, deep), 0.0


class Table(_Furniture):
    """A table with four legs."""

    centre: tuple[Coordinate, Coordinate]  # x, y in the world [m]
    size: tuple[Length, Length] = (1.2, 0.6)  # Along x and y [m]
    height: Length = 0.5  # Of the top side [m]

    @property
    def outline(self) -> tuple[tuple[float, float], tuple[float, float], float]:
        """See `_Furniture`."""
        return self.centre, self.size, 0.0


class Fixture(_Furniture, MeshFile):
    """A box or a mesh that never moves."""

    name: Name
    centre: tuple[Coordinate, Coordinate, Coordinate]
    """x, y, z of the middle of its bounding box in the world [m]."""
    size: tuple[Length, Length, Length] | None = None  # Full edge lengths of a box [m]
    yaw_deg: Annotated[float, Field(ge=-360.0, le=360.0)] = 0.0
    on_map: bool = True  # Whether the robot is told that it stands there

    @model_validator(mode="after")
    def _is_one_thing(self) -> Fixture:
        if (self.size is None) == (self.mesh is None):
            raise ValueError("is neither a box nor a mesh, or both; write `size` or `mesh`")
        return self

    @property
    def edges(self) -> tuple[float, float, float]:
        """Of its bounding box before it is turned [m]."""
        if self.size is not None:
            return self.size
        x, y, z = self.read().half if self.mesh else (0.0, 0.0, 0.0)
        return 2.0 * x, 2.0 * y, 2.0 * z

    @property
    def low(self) -> float:
        """See `_Furniture`."""
        return self.centre[2] - self.edges[2] / 2.0

    @property
    def outline(self) -> tuple[tuple[float, float], tuple[float, float], float]:
        """See `_Furniture`."""
        return self.centre[:2], self.edges[:2], radians(self.yaw_deg)


_Millimetres = Annotated[float, Field(gt=0.0, le=1000.0)]
_Grams = Annotated[float, Field(gt=0.0, le=100_000.0)]


def _is_known(kind: str) -> str:
    if kind not in OBJECT_CLASSES:
        raise ValueError(f"no kind of object is called `{kind}`; {suggest(kind, OBJECT_CLASSES)}")
    return kind


class Item(MeshFile):
    """One object that is there for sure."""

    SIZES: ClassVar[tuple[float, float]] = (0.01, 0.6)

    kind: Annotated[str, AfterValidator(_is_known)] | None = None
    mass_g: _Grams | None = None  # Drawn if it is not given, as for any other object [g]
    colour: ColourName | None = None  # Drawn if it is not given
    friction: Annotated[float, Field(ge=0.05, le=3.0)] | None = None
    """Coulomb friction with the finger pads; drawn if it is not given."""
    at: tuple[Coordinate, Coordinate] | None = None
    """x, y in the world of the middle of its bounding box [m]; drawn if it is not given."""
    yaw_deg: Annotated[float, Field(ge=-360.0, le=360.0)] | None = None
    """Drawn if it is not given, and 0 if `at` is."""

    @model_validator(mode="after")
    def _is_one_thing(self) -> Item:
        if (self.kind is None) == (self.mesh is None):
            raise ValueError("is of no kind and no mesh, or of both; write `kind` or `mesh`")
        return self


class Objects(StrictModel):
    """The objects in the container, or on a table."""

    items: Annotated[tuple[Item, ...], AfterValidator(few)] = ()
    """Those that are there for sure; all the others are drawn."""
    count: Annotated[int, Field(ge=0, le=40)] = 10
    """How many are drawn; none if there are items and it is not given."""
    kinds: tuple[str, ...] = tuple(HOUSEHOLD)
    width_mm: tuple[_Millimetres, _Millimetres] = (15.0, 70.0)
    """Range of the smallest width by which they can be grasped [mm]."""
    mass_g: tuple[_Grams, _Grams] = (30.0, 500.0)  # Range of their mass [g]

    @field_validator("kinds")
    @classmethod
    def _known(cls, kinds: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(_is_known(kind) for kind in kinds)

    @field_validator("width_mm", "mass_g")
    @classmethod
    def _ascending(cls, bounds: tuple[float, float]) -> tuple[float, float]:
        if bounds[0] > bounds[1]:
            raise ValueError("must be the smallest, then the largest")
        return bounds

    @property
    def drawn(self) -> int:
        """How many are drawn."""
        return self.count if "count" in self.model_fields_set or not self.items else 0


class Motion(StrictModel):
    """How the objects on a table move by themselves: along a line, back and forth."""

    along: tuple[Coordinate, Coordinate]  # x, y from one end of the line to the other [m]
    period_s: Annotated[float, Field(ge=0.1, le=1e6)]  # From one end to the other and back [s]
    stop_s: Annotated[float, Field(ge=0.0, le=1e9)] | None = None
    """Simulated time from which they stand still [s]; without it they never stop."""
    steady: bool = False
    """Whether they are always as fast, as on a belt; else they turn round smoothly."""


class SideTable(Table):
    """Another table, with objects anywhere on it."""

    name: Name
    objects: Objects
    motion: Motion | None = None


class Walker(_Furniture):
    """An upright cylinder, as large as a person, that walks to and fro."""

    name: Name
    radius: Annotated[float, Field(ge=0.02, le=2.0)] = 0.25  # [m]
    height: Annotated[float, Field(ge=0.1, le=5.0)] = 1.75  # [m]
    way: Annotated[tuple[tuple[Coordinate, Coordinate], ...], Field(min_length=2, max_length=100)]
    """x, y of the points between which it walks in straight lines: from the first to the last, and
    back [m]."""
    speed: Annotated[float, Field(ge=0.01, le=3.0)] = 1.0  # Between them [m/s]

    @field_validator("way")
    @classmethod
    def _leads_somewhere(
        cls, way: tuple[tuple[float, float], ...]
    ) -> tuple[tuple[float, float], ...]:
        if any(hypot(x - u, y - v) < 0.01 for (x, y), (u, v) in pairwise(way)):
            raise ValueError("two points in a row are the same; leave one out")
        return way

    @property
    def outline(self) -> tuple[tuple[float, float], tuple[float, float], float]:
        """See `_Furniture`; where it is at the start."""
        return self.way[0], (2.0 * self.radius, 2.0 * self.radius), 0.0
