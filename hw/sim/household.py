"""Household-like objects, made from a seed: boxes, cans, mugs, hammers and their kin.

Each maker takes the smallest width by which the object can be grasped from above, and returns its
parts as it rests on z = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from pinocchio import SE3, exp3

from hw.sim.objects import SimObject
from hw.sim.shapes import Box, Capsule, Colour, Cylinder, Placed, Shape, Sphere, volume

Parts: TypeAlias = list[Placed]
Maker: TypeAlias = Callable[[np.random.Generator, float], Parts]

MAX_LENGTH = 0.16
"""No object is longer than this [m]."""

MAX_FOOTPRINT = 0.006
"""No box or cylinder covers more than this as it rests [m²]."""

MAX_HEIGHT = 0.11
"""No object is higher than this as it rests [m]."""

_ALONG_X = exp3(np.array([0.0, np.pi / 2.0, 0.0]))
_DENSITY = (200.0, 1200.0)
_FRICTION = (0.45, 0.7)

PALETTE: tuple[Colour, ...] = (
    (214, 84, 70),
    (240, 170, 60),
    (246, 214, 92),
    (110, 178, 96),
    (70, 150, 190),
    (84, 104, 184),
    (150, 96, 172),
    (200, 130, 100),
    (120, 130, 140),
    (230, 140, 160),
)


def _part(shape: Shape, x: float, y: float, z: float, *, lying: bool = False) -> Placed:
    return Placed(shape, SE3(_ALONG_X if lying else np.eye(3), np.array([x, y, z])))


def _longest(width: float) -> float:
    return min(MAX_LENGTH, MAX_FOOTPRINT / width)


def _box(rng: np.random.Generator, width: float) -> Parts:
    length = rng.uniform(width, _longest(width))
    height = rng.uniform(max(0.02, 0.5 * width), min(MAX_HEIGHT, max(0.04, 2.0 * width)))
    return [_part(Box((length / 2.0, width / 2.0, height / 2.0)), 0.0, 0.0, height / 2.0)]


def _cylinder(rng: np.random.Generator, width: float) -> Parts:
    length = rng.uniform(max(1.2 * width, 0.05), _longest(width))
    return [_part(Cylinder(width / 2.0, length / 2.0), 0.0, 0.0, width / 2.0, lying=True)]


def _can(rng: np.random.Generator, width: float) -> Parts:
    height = rng.uniform(0.04, min(MAX_HEIGHT, 2.5 * width))
    return [_part(Cylinder(width / 2.0, height / 2.0), 0.0, 0.0, height / 2.0)]


def _ball(_: np.random.Generator, width: float) -> Parts:
    return [_part(Sphere(width / 2.0), 0.0, 0.0, width / 2.0)]


def _capsule(rng: np.random.Generator, width: float) -> Parts:
    length = rng.uniform(max(0.5 * width, 0.02), _longest(width) - width)
    return [_part(Capsule(width / 2.0, length / 2.0), 0.0, 0.0, width / 2.0, lying=True)]


def _mug(rng: np.random.Generator, width: float) -> Parts:
    """Its handle is what `width` is about."""
    radius, height = rng.uniform(0.02, 0.03), rng.uniform(0.06, 0.09)
    handle = Box((0.016, width / 2.0, 0.35 * height))
    return [
        _part(Cylinder(radius, height / 2.0), 0.0, 0.0, height / 2.0),
        _part(handle, radius + 0.012, 0.0, height / 2.0),
    ]


def _hammer(rng: np.random.Generator, width: float) -> Parts:
    length = rng.uniform(0.09, 0.12)
    thick = rng.uniform(0.5, 0.8) * width
    head = Box((thick, rng.uniform(0.03, 0.04), rng.uniform(0.6, 0.8) * width))
    return [
        _part(Cylinder(width / 2.0, length / 2.0), 0.0, 0.0, width / 2.0, lying=True),
        _part(head, length / 2.0, 0.0, head.half[2]),
    ]


def _screwdriver(rng: np.random.Generator, width: float) -> Parts:
    """Its shaft is what `width` is about."""
    handle = Capsule(rng.uniform(0.65, 0.8) * width, 0.03)
    shaft = Cylinder(width / 2.0, rng.uniform(0.02, 0.03))
    reach = handle.half_length + handle.radius + shaft.half_length
    return [
        _part(handle, 0.0, 0.0, handle.radius, lying=True),
        _part(shaft, 0.95 * reach, 0.0, handle.radius, lying=True),
    ]


def _corner(rng: np.random.Generator, width: float) -> Parts:
    height = rng.uniform(0.025, 0.05)
    a, b = rng.uniform(0.07, 0.11), rng.uniform(0.06, 0.09)
    half = width / 2.0
    return [
        _part(Box((a / 2.0, half, height / 2.0)), a / 2.0 - half, 0.0, height / 2.0),
        _part(Box((half, b / 2.0, height / 2.0)), 0.0, b / 2.0 - half, height / 2.0),
    ]


def _tee(rng: np.random.Generator, width: float) -> Parts:
    height = rng.uniform(0.025, 0.05)
    stem, bar = rng.uniform(0.06, 0.09), rng.uniform(0.08, 0.11)
    half = width / 2.0
    return [
        _part(Box((stem / 2.0, half, height / 2.0)), stem / 2.0 - half, 0.0, height / 2.0),
        _part(Box((half, bar / 2.0, height / 2.0)), 0.0, 0.0, height / 2.0),
    ]


def _dumbbell(rng: np.random.Generator, width: float) -> Parts:
    end = width / 2.0 + rng.uniform(0.005, 0.012)
    half_length = rng.uniform(0.03, 0.04)
    return [
        _part(Cylinder(width / 2.0, half_length), 0.0, 0.0, end, lying=True),
        _part(Sphere(end), half_length, 0.0, end),
        _part(Sphere(end), -half_length, 0.0, end),
    ]


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of object, and the widths that become it."""

    make: Maker
    narrowest: float = 0.015
    """[m]."""
    widest: float = 0.07
    """[m]."""


KINDS: dict[str, Kind] = {
    "box": Kind(make=_box),
    "cylinder": Kind(make=_cylinder),
    "can": Kind(make=_can, narrowest=0.025),
    "ball": Kind(make=_ball, narrowest=0.025),
    "capsule": Kind(make=_capsule, widest=0.05),
    "mug": Kind(make=_mug, widest=0.025),
    "hammer": Kind(make=_hammer, widest=0.03),
    "screwdriver": Kind(make=_screwdriver, widest=0.03),
    "corner": Kind(make=_corner, widest=0.035),
    "tee": Kind(make=_tee, widest=0.035),
    "dumbbell": Kind(make=_dumbbell, widest=0.03),
}
"""Every kind of object that a scene may ask for."""


def fitting(kinds: Sequence[str], widths: tuple[float, float]) -> list[str]:
    """Those of the kinds that come in a range of widths [m]."""
    low, high = widths
    return [k for k in kinds if KINDS[k].narrowest <= high and KINDS[k].widest >= low]


def make_object(
    name: str,
    kind: str,
    widths: tuple[float, float],
    masses: tuple[float, float],
    rng: np.random.Generator,
) -> SimObject:
    """One object, resting on z = 0 with its centre of mass above the origin.

    Args:
        name: what to call it.
        kind: one of `KINDS` that is `fitting`.
        widths: range of the smallest width by which it can be grasped [m].
        masses: range of its mass [kg].
        rng: where the randomness comes from.
    """
    low, high = max(widths[0], KINDS[kind].narrowest), min(widths[1], KINDS[kind].widest)
    parts = KINDS[kind].make(rng, rng.uniform(low, high))
    volumes = np.array([volume(p.shape) for p in parts])
    centre = volumes @ np.array([p.pose.translation for p in parts]) / volumes.sum()
    colour = PALETTE[rng.integers(len(PALETTE))]
    return SimObject(
        name=name,
        parts=tuple(
            Placed(p.shape, SE3(p.pose.rotation, p.pose.translation - centre), name, colour)
            for p in parts
        ),
        mass=float(np.clip(volumes.sum() * rng.uniform(*_DENSITY), *masses)),
        friction=rng.uniform(*_FRICTION),
        pose=SE3(np.eye(3), np.array([0.0, 0.0, centre[2]])),
    )
