"""Object classes: makers of parts at rest on z = 0 from the width by which a hand grasps them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from pinocchio import SE3, exp3

from hw.sim.sim_object import SimObject
from perception import ColourName
from robots import Array, Box, Colour, Cylinder, Geom, Shape, centroid, volume

Parts: TypeAlias = list[Geom]
Maker: TypeAlias = Callable[[np.random.Generator, float], Parts]

MAX_LENGTH = 0.16  # Largest length of an object [m]

MAX_FOOTPRINT = 0.006  # Largest area that a box or cylinder covers as it rests [m²]

MAX_HEIGHT = 0.11  # Largest height of an object as it rests [m]

_LYING = exp3(np.array([0.0, np.pi / 2.0, 0.0]))
DENSITY = (200.0, 1200.0)  # [kg/m³]
FRICTION = (0.45, 0.7)  # Coulomb coefficient with the finger pads

PALETTE: tuple[Colour, ...] = (
    *((214, 84, 70), (240, 170, 60), (246, 214, 92), (110, 178, 96), (70, 150, 190)),
    *((84, 104, 184), (150, 96, 172), (200, 130, 100), (120, 130, 140), (230, 140, 160)),
)

PAINT: Mapping[ColourName, Colour] = {
    **{"red": (214, 60, 50), "orange": (240, 150, 40), "yellow": (246, 214, 60)},
    **{"green": (80, 170, 80), "blue": (60, 110, 190), "purple": (140, 80, 170)},
    **{"pink": (235, 140, 170), "brown": (130, 85, 55), "white": (240, 240, 235)},
    **{"grey": (130, 130, 130), "black": (30, 30, 30)},
}
"""Colours by name in scene files."""


@dataclass(frozen=True, kw_only=True)
class ObjectClass:
    """A class of objects, and its range of widths."""

    make: Maker
    narrowest: float = 0.015  # [m]
    widest: float = 0.07  # [m]


def part(
    shape: Shape, x: float, y: float, z: float, *, lying: bool = False, yaw: float = 0.0
) -> Geom:
    """A part with its centre at x, y, z [m]; lying: along x; then turned by `yaw` [rad]."""
    turn = exp3(np.array([0.0, 0.0, yaw]))
    return Geom(shape, SE3(turn @ _LYING if lying else turn, np.array([x, y, z])))


def box(
    length: float, width: float, height: float, x: float = 0.0, y: float = 0.0, z: float = 0.0
) -> Geom:
    """A box on a surface at height z, its middle at x, y [m]."""
    return part(Box((length / 2.0, width / 2.0, height / 2.0)), x, y, z + height / 2.0)


def disc(radius: float, height: float, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Geom:
    """An upright cylinder on a surface at height z, its middle at x, y [m]."""
    return part(Cylinder(radius, height / 2.0), x, y, z + height / 2.0)


def longest(width: float) -> float:
    """Largest length of an object of a width [m]."""
    return min(MAX_LENGTH, MAX_FOOTPRINT / width)


def fitting(
    classes: Mapping[str, ObjectClass], names: Sequence[str], widths: tuple[float, float]
) -> list[str]:
    """The named classes that have objects in a range of widths [m]."""
    low, high = widths
    return [n for n in names if classes[n].narrowest <= high and classes[n].widest >= low]


def make_object(
    name: str,
    object_class: ObjectClass,
    widths: tuple[float, float],
    masses: tuple[float, float],
    rng: np.random.Generator,
) -> SimObject:
    """A random object of these widths and masses [m, kg], at rest on z = 0, centred above 0."""
    low, high = max(widths[0], object_class.narrowest), min(widths[1], object_class.widest)
    parts = object_class.make(rng, rng.uniform(low, high))
    return body_of(name, parts, masses, rng)


def body_of(
    name: str, parts: Sequence[Geom], masses: tuple[float, float], rng: np.random.Generator
) -> SimObject:
    """A body of parts as they lie, its origin the centre of mass, of random colour and density."""
    whole, centre = mass_properties(parts)
    colour = PALETTE[rng.integers(len(PALETTE))]
    return SimObject(
        name=name,
        parts=tuple(
            Geom(p.shape, SE3(p.pose.rotation, p.pose.translation - centre), name, colour)
            for p in parts
        ),
        mass=float(np.clip(whole * rng.uniform(*DENSITY), *masses)),
        friction=rng.uniform(*FRICTION),
        pose=SE3(np.eye(3), np.array([0.0, 0.0, centre[2]])),
    )


def mass_properties(parts: Sequence[Geom]) -> tuple[float, Array]:
    """Volume [m³] and centre of mass (3,) of parts [m]."""
    volumes = np.array([volume(p.shape) for p in parts])
    centres = np.array([p.pose.act(centroid(p.shape)) for p in parts])
    return volumes.sum(), volumes @ centres / volumes.sum()
