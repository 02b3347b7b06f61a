"""The sections `poses` and `regions`: metres and degrees in, ready-made objects out."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
import pinocchio as pin
from pinocchio import SE3

from behaviours.named import BasePose, Posture, Region, ToolPose
from config import quoted
from robots import load_robot
from trees.language.diagnostics import Diagnostics, Location
from trees.language.source import Entry, Items, Scalar, Value
from trees.language.tables import fields, named_entries
from trees.language.value_types import Named
from trees.language.values import describe

Vector: TypeAlias = npt.NDArray[np.float64]

BUILT_IN: Mapping[str, Named] = {"ready": Posture(name="ready", q=load_robot("frankie").arm.ready)}
"""What every task file knows without defining it."""


@dataclass
class Places:
    """The named poses, postures and regions of a file."""

    named: dict[str, Named] = field(default_factory=lambda: dict(BUILT_IN))
    defined: dict[str, Location] = field(default_factory=dict)
    """Where the file defines each, whether or not the definition is sound."""
    regions: set[str] = field(default_factory=set)
    """Those that are defined as regions."""


def tool_pose(name: str, xyz: Vector, rpy_deg: Vector) -> ToolPose:
    """End effector at `xyz` [m], turned by Rz(yaw) Ry(pitch) Rx(roll) [degrees]."""
    return ToolPose(name=name, wTe=SE3(pin.rpy.rpyToMatrix(np.deg2rad(rpy_deg)), xyz))


def base_pose(name: str, base: Vector, heading_deg: float) -> BasePose:
    """Base at x, y [m] on the floor, heading counted from the world's x axis [degrees]."""
    heading = pin.utils.rotate("z", math.radians(heading_deg))
    return BasePose(name=name, wTb=SE3(heading, np.append(base, 0.0)))


def posture(name: str, joints_deg: Vector) -> Posture:
    """Arm joints from base to hand [degrees]."""
    return Posture(name=name, q=np.deg2rad(joints_deg))


def region(name: str, centre: Vector, size: Vector, yaw_deg: float = 0.0) -> Region:
    """A box at `centre` with edges `size` [m], turned about the vertical [degrees]."""
    turn = pin.utils.rotate("z", math.radians(yaw_deg))
    return Region(name=name, wTr=SE3(turn, centre), size=size)


@dataclass(frozen=True, kw_only=True)
class _Form:
    """One way to write a place: its keys, how many numbers each takes, and what it makes."""

    required: Mapping[str, int]
    optional: Mapping[str, int] = field(default_factory=dict)
    make: Callable[..., Named]


_POSES = (
    _Form(required={"xyz": 3, "rpy_deg": 3}, make=tool_pose),
    _Form(required={"base": 2, "heading_deg": 1}, make=base_pose),
    _Form(required={"joints_deg": 7}, make=posture),
)
_REGION = _Form(required={"centre": 3, "size": 3}, optional={"yaw_deg": 1}, make=region)


def read_places(poses: Entry | None, regions: Entry | None, diagnostics: Diagnostics) -> Places:
    """The poses and regions of a file; unsound ones are noted as diagnostics and left out."""
    places = Places()
    for section, entry in (("poses", poses), ("regions", regions)):
        for name, place, value in named_entries(entry, section, diagnostics):
            if name in BUILT_IN:
                hint = "choose another name"
                diagnostics.error(place, f"`{name}` is built in and cannot be redefined", hint)
                continue
            if name in places.defined:
                what = f"`{name}` is a pose already, on line {places.defined[name].line}"
                diagnostics.error(place, what, "choose another name")
                continue
            places.defined[name] = place
            if section == "regions":
                places.regions.add(name)
            thing = _read_place(name, place, value, section, diagnostics)
            if thing is not None:
                places.named[name] = thing
    return places


def _read_place(
    name: str, place: Location, value: Value, section: str, diagnostics: Diagnostics
) -> Named | None:
    form = _REGION if section == "regions" else _pose_form(name, place, value, diagnostics)
    if form is None:
        return None
    what = f"{section.removesuffix('s')} `{name}`"
    entries = fields(value, what, diagnostics, required=form.required, optional=form.optional)
    if entries is None:
        return None
    counts = {**form.required, **form.optional}
    numbers = {
        key: _numbers(entry.value, counts[key], key, diagnostics)
        for key, entry in entries.items()
        if key in counts
    }
    if any(number is None for number in numbers.values()):
        return None
    if form is _REGION and np.min(np.asarray(numbers["size"])) <= 0.0:
        hint = "give the full length of each edge [m]"
        diagnostics.error(
            entries["size"].value.place, f"{what} has an edge that is not positive", hint
        )
        return None
    return form.make(name, **numbers)


def _pose_form(name: str, place: Location, value: Value, diagnostics: Diagnostics) -> _Form | None:
    """The form that a pose is written in, told by the keys that it has."""
    keys = set(getattr(value, "entries", ()))
    forms = [form for form in _POSES if keys & set(form.required)]
    if len(forms) == 1:
        return forms[0]
    ways = ", ".join(f"{quoted(form.required).replace(', ', ' and ')}" for form in _POSES)
    hint = f"write one of {ways}"
    if forms:
        diagnostics.error(place, f"pose `{name}` mixes keys of different kinds of pose", hint)
    else:
        diagnostics.error(place, f"pose `{name}` does not say where it is", hint)
    return None


def _numbers(value: Value, count: int, key: str, diagnostics: Diagnostics) -> Vector | float | None:
    """One finite number, or a list of `count` of them; None and a diagnostic otherwise."""
    if count == 1:
        return _number(value, key, diagnostics)
    if not isinstance(value, Items) or len(value.items) != count:
        got = f"{len(value.items)}" if isinstance(value, Items) else describe(value)
        example = f"write `{key}: [{', '.join(['0.0'] * count)}]`"
        diagnostics.error(value.place, f"`{key}` is a list of {count} numbers, not {got}", example)
        return None
    numbers = [_number(item, key, diagnostics) for item in value.items]
    if any(number is None for number in numbers):
        return None
    return np.array(numbers, dtype=np.float64)


def _number(value: Value, key: str, diagnostics: Diagnostics) -> float | None:
    number = value.value if isinstance(value, Scalar) else None
    if isinstance(number, int | float) and not isinstance(number, bool) and math.isfinite(number):
        return float(number)
    if not (isinstance(value, Scalar) and value.is_noted):
        diagnostics.error(
            value.place, f"`{key}` takes finite numbers, not {describe(value)}", "write a number"
        )
    return None
