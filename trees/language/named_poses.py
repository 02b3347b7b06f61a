"""The sections `poses` and `regions`, of a task file or of a file of places."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import numpy as np
from pinocchio import SE3, rpy, utils
from pydantic import AfterValidator, Field, WithJsonSchema, model_validator

from behaviours import BasePose, Posture, Region, ToolPose
from config import (
    Diagnostics,
    Hint,
    Location,
    YamlEntry,
    YamlList,
    YamlMap,
    YamlScalar,
    YamlValue,
    quoted,
    read_yaml,
    texts,
)
from config.reader import StrictModel, validate
from trees.language import rules
from trees.language.mappings import ABSENT, fields, named_entries
from trees.language.values import OTHER_UNITS, meant, radians_for_degrees
from trees.words import NamedValue

READY = Posture(name="ready", q=np.zeros(0))
"""It is not known before a tree is built for a robot."""

BUILT_IN: Mapping[str, NamedValue] = {READY.name: READY}  # known without being defined

_POSE_FORMS = (("xyz", "rpy_deg"), ("base", "heading_deg"), ("joints_deg",))

_FARTHEST = 100.0  # coordinate [m]
_LONGEST = 10.0  # edge of a region [m]
_MOST_DEGREES = 360.0


def _coordinate(number: float) -> float:
    if abs(number) > _FARTHEST:
        hint = meant(number, "m", lambda metres: abs(metres) <= _FARTHEST)
        limit = f"write at most {_FARTHEST:g}"
        raise ValueError(f"{number:g} m is far outside of the room; {hint or limit}")
    return number


def _edge(length: float) -> float:
    if length <= 0.0:
        raise ValueError("an edge is not positive; give the full length of each edge [m]")
    if length > _LONGEST:
        hint = meant(length, "m", lambda metres: metres <= _LONGEST)
        limit = f"write at most {_LONGEST:g}"
        raise ValueError(f"an edge of {length:g} m is longer than {_LONGEST:g} m; {hint or limit}")
    return length


def _angle(number: float) -> float:
    if abs(number) > _MOST_DEGREES:
        raise ValueError(f"{number:g}° is more than a turn; write -360 to 360")
    if odd := radians_for_degrees(number):
        raise ValueError(odd)
    return number


def _schema(**bounds: float) -> WithJsonSchema:
    """What an editor is told of a number that is checked here."""
    return WithJsonSchema({"type": "number"} | bounds)


_Coordinate = Annotated[
    float, AfterValidator(_coordinate), _schema(minimum=-_FARTHEST, maximum=_FARTHEST)
]
_Edge = Annotated[float, AfterValidator(_edge), _schema(exclusiveMinimum=0.0, maximum=_LONGEST)]
_Angle = Annotated[
    float, AfterValidator(_angle), _schema(minimum=-_MOST_DEGREES, maximum=_MOST_DEGREES)
]
_Pair = Annotated[list[_Coordinate], Field(min_length=2, max_length=2)]
_Triple = Annotated[list[_Coordinate], Field(min_length=3, max_length=3)]
_Angles = Annotated[list[_Angle], Field(min_length=3, max_length=3)]
_Edges = Annotated[list[_Edge], Field(min_length=3, max_length=3)]
_Joints = Annotated[list[_Angle], Field(min_length=1, max_length=12)]


class PoseSection(StrictModel):
    """A pose in a task file, written in one of three forms."""

    xyz: _Triple = Field(
        default=ABSENT, description="Point between the finger tips, in the world [m]."
    )
    rpy_deg: _Angles = Field(
        default=ABSENT, description="Roll, pitch and yaw of the hand [°]; roll 180 looks down."
    )
    base: _Pair = Field(default=ABSENT, description="x and y of the base on the floor [m].")
    heading_deg: _Angle = Field(
        default=ABSENT, description="Where the base faces, from the world's x axis [°]."
    )
    joints_deg: _Joints = Field(
        default=ABSENT,
        description="Posture of the arm, from base to hand [°, or m for a sliding joint].",
    )
    on: str = Field(
        default=ABSENT, description="Furniture of the map with which a pose of the hand moves."
    )

    @model_validator(mode="before")
    @classmethod
    def _empty(cls, value: object) -> object:
        return {} if value is None else value

    @model_validator(mode="after")
    def _one_form(self) -> PoseSection:
        given = self.model_fields_set
        forms = [form for form in _POSE_FORMS if given & set(form)]
        if len(forms) == 1 and (missing := [key for key in forms[0] if key not in given]):
            raise ValueError(f"lacks {quoted(missing)}; add {quoted(missing)}")
        if len(forms) != 1:
            problem = "mixes forms of pose" if forms else "is empty"
            ways = ", ".join(quoted(form).replace(", ", " and ") for form in _POSE_FORMS)
            raise ValueError(f"{problem}; write one of {ways}")
        if self.on and "xyz" not in given:
            raise ValueError("`on` is for poses of the hand; leave it out")
        return self

    def make(self, name: str) -> ToolPose | BasePose | Posture:
        """The pose: Rz(yaw) Ry(pitch) Rx(roll) for a tool, a turn about z for a base."""
        if "xyz" in self.model_fields_set:
            turn = rpy.rpyToMatrix(np.deg2rad(self.rpy_deg))
            return ToolPose(name=name, mTe=SE3(turn, np.array(self.xyz)), on=self.on or "")
        if "base" in self.model_fields_set:
            return BasePose(name=name, mTb=_upright([*self.base, 0.0], self.heading_deg))
        return Posture(name=name, q=np.deg2rad(self.joints_deg))


class RegionSection(StrictModel):
    """A box in a task file."""

    centre: _Triple = Field(description="Middle of the box in the world [m].")
    size: _Edges = Field(description="Full length of each edge [m].")
    yaw_deg: _Angle = Field(default=0.0, description="Turn about the vertical [°].")
    front_deg: _Angle = Field(
        default=ABSENT,
        description="Where a hand points that reaches in, from the world's x axis [°].",
    )
    on: str = Field(default=ABSENT, description="Furniture of the map with which the box moves.")

    def make(self, name: str) -> Region:
        """The region."""
        mTr = _upright(self.centre, self.yaw_deg)
        front = math.radians(self.front_deg) if "front_deg" in self.model_fields_set else None
        return Region(name=name, mTr=mTr, size=np.array(self.size), front=front, on=self.on or "")


def _upright(xyz: list[float], yaw_deg: float) -> SE3:
    return SE3(utils.rotate("z", math.radians(yaw_deg)), np.array(xyz))


@dataclass
class NamedValues:
    """The poses, postures and regions of a file."""

    values: dict[str, NamedValue] = field(default_factory=lambda: dict(BUILT_IN))
    locations: dict[str, Location] = field(default_factory=dict)
    """Where the file defines each, whether or not the definition is sound."""
    files: dict[str, Path] = field(default_factory=dict)
    """Of those that another file defines instead, that file."""
    paths: dict[str, list[str]] = field(default_factory=dict)
    """The names of the poses of each path, in order."""

    def take(self, others: NamedValues, path: Path) -> None:
        """Take what another file defines, in place of what has the same name here."""
        self.paths |= others.paths
        for name, location in others.locations.items():
            self.values.pop(name, None)
            if name in others.values:
                self.values[name] = others.values[name]
            self.locations[name], self.files[name] = location, path

    def is_faulty(self, name: object) -> bool:
        """Whether the file defines something of this name, with an error that is noted."""
        return name in self.locations and name not in self.values

    def defined(self, *types: type) -> dict[str, NamedValue]:
        """Those of some types that the file defines."""
        found = {name: self.values[name] for name in self.locations if name in self.values}
        return {name: value for name, value in found.items() if isinstance(value, types)}


def read_named_values(
    poses: YamlEntry | None, regions: YamlEntry | None, diagnostics: Diagnostics
) -> NamedValues:
    """The poses and regions of a file; errors are noted, and those entries left out."""
    named = NamedValues()
    sections: tuple[tuple[str, YamlEntry | None, type[PoseSection | RegionSection]], ...] = (
        ("poses", poses, PoseSection),
        ("regions", regions, RegionSection),
    )
    for section, entry, model in sections:
        for name, location, value in _one_by_one(entry, section, named.paths, diagnostics):
            if name in BUILT_IN:
                message = f"`{name}` is built in and cannot be redefined"
                diagnostics.error(rules.NAMING, location, message, "choose another name")
                continue
            if name in named.locations:
                message = f"`{name}` is a pose already, on line {named.locations[name].line}"
                diagnostics.error(rules.NAMING, location, message, "choose another name")
                continue
            named.locations[name] = location
            full_name = f"{section}.{name}"
            # Only the tree may have `$name`.
            if reference := next((one for one in texts(value) if one[0].startswith("$")), None):
                message = f"{full_name}: `{reference[0]}` stands in place of a number"
                hint = "write numbers here, and choose among poses by a parameter of type `pose`"
                diagnostics.error(rules.VALUE, reference[1], message, hint)
                continue
            if _is_in_other_unit(value, full_name, diagnostics):
                continue
            checked = validate(value, model, diagnostics, name=full_name, location=location)
            if checked is not None:
                named.values[name] = checked.make(name)
    return named


def _is_in_other_unit(value: YamlValue, name: str, diagnostics: Diagnostics) -> bool:
    """Whether a point or box is in millimetres or centimetres, as its large numbers show; noted.

    The height of most points, or the longest edge of most boxes, tells which.
    """
    shared = False
    for key, least, most in (("xyz", 0.3, 2.0), ("centre", 0.3, 2.0), ("size", 0.15, _LONGEST)):
        entry = value.entries.get(key) if isinstance(value, YamlMap) else None
        items = entry.value.items if entry and isinstance(entry.value, YamlList) else ()
        numbers = [one.value for one in items if isinstance(one, YamlScalar)]
        given = [float(one) for one in numbers if type(one) in (int, float)]  # type: ignore[arg-type]
        large = [abs(number) for number in given if abs(number) >= 10.0]
        if not len(given) == len(items) == 3 or not large or (key == "size" and len(large) == 1):
            continue
        telling = max(large) if key == "size" else abs(given[2])
        units = [one for one in OTHER_UNITS["m"] if least <= telling * one[1] <= most]
        for at, (one, number) in enumerate(zip(items, given, strict=True) if units else ()):
            if abs(number) in large:
                unit, factor = units[0]
                hint = f"did you mean {number * factor:g} (from {unit}, as all of `{key}`)?"
                certain = Hint(hint, f"{number:g}", f"{number * factor:g}")
                message = f"{name}.{key}.{at}: {number:g} m is far outside of the room"
                diagnostics.error(rules.VALUE, one.location, message, certain)
                shared = True
    return shared


def _one_by_one(
    entry: YamlEntry | None, section: str, paths: dict[str, list[str]], diagnostics: Diagnostics
) -> Iterator[tuple[str, Location, YamlValue]]:
    """As `named_entries`, but each pose of a list by itself; `paths` gets their names."""
    for name, location, value in named_entries(entry, section, diagnostics):
        if section == "poses" and isinstance(value, YamlList):
            paths[name] = [f"{name}_{number}" for number in range(1, len(value.items) + 1)]
            for point, pose in zip(paths[name], value.items, strict=True):
                yield point, pose.location, pose
        else:
            yield name, location, value


SITE_KEYS = ("description", "poses", "regions")  # what may stand in such a file


def read_site(diagnostics: Diagnostics) -> NamedValues:
    """What the file defines that the diagnostics are about."""
    read = read_yaml(diagnostics)
    entries = read and fields(read[1], "the file of places", diagnostics, optional=SITE_KEYS)
    if not entries:
        return NamedValues()
    return read_named_values(entries.get("poses"), entries.get("regions"), diagnostics)
