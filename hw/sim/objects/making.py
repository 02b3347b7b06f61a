"""What a kind of object is, and making one of it.

A maker takes the smallest width by which the object can be grasped from above, and returns its
parts as it rests on z = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from pinocchio import SE3, exp3

from hw.sim.sim_object import SimObject
from robots.shapes import Colour, Geom, Shape, volume

Parts: TypeAlias = list[Geom]
Maker: TypeAlias = Callable[[np.random.Generator, float], Parts]

MAX_LENGTH = 0.16
"""No object is longer than this [m]."""

MAX_FOOTPRINT = 0.006
"""No box or cylinder covers more than this as it rests [m²]."""

MAX_HEIGHT = 0.11
"""No object is higher than this as it rests [m]."""

_LYING = exp3(np.array([0.0, np.pi / 2.0, 0.0]))
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


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of object, and the widths that become it."""

    make: Maker
    narrowest: float = 0.015
    """[m]."""
    widest: float = 0.07
    """[m]."""


def part(
    shape: Shape, x: float, y: float, z: float, *, lying: bool = False, yaw: float = 0.0
) -> Geom:
    """A part with its centre at a point.

    Args:
        shape: what it is.
        x: centre [m].
        y: [m].
        z: [m].
        lying: its axis along x instead of z, before it is turned.
        yaw: by how much it is turned about z [rad].
    """
    turn = exp3(np.array([0.0, 0.0, yaw]))
    return Geom(shape, SE3(turn @ _LYING if lying else turn, np.array([x, y, z])))


def longest(width: float) -> float:
    """How long an object of a width may be [m]."""
    return min(MAX_LENGTH, MAX_FOOTPRINT / width)


def fitting(
    kinds: Mapping[str, Kind], names: Sequence[str], widths: tuple[float, float]
) -> list[str]:
    """Those of the named kinds that come in a range of widths [m]."""
    low, high = widths
    return [n for n in names if kinds[n].narrowest <= high and kinds[n].widest >= low]


def make_object(
    name: str,
    kind: Kind,
    widths: tuple[float, float],
    masses: tuple[float, float],
    rng: np.random.Generator,
) -> SimObject:
    """One object, resting on z = 0 with its centre of mass above the origin.

    Args:
        name: what to call it.
        kind: one that is `fitting`.
        widths: range of the smallest width by which it can be grasped [m].
        masses: range of its mass [kg].
        rng: where the randomness comes from.
    """
    low, high = max(widths[0], kind.narrowest), min(widths[1], kind.widest)
    parts = kind.make(rng, rng.uniform(low, high))
    volumes = np.array([volume(p.shape) for p in parts])
    centre = volumes @ np.array([p.pose.translation for p in parts]) / volumes.sum()
    colour = PALETTE[rng.integers(len(PALETTE))]
    return SimObject(
        name=name,
        parts=tuple(
            Geom(p.shape, SE3(p.pose.rotation, p.pose.translation - centre), name, colour)
            for p in parts
        ),
        mass=float(np.clip(volumes.sum() * rng.uniform(*_DENSITY), *masses)),
        friction=rng.uniform(*_FRICTION),
        pose=SE3(np.eye(3), np.array([0.0, 0.0, centre[2]])),
    )
