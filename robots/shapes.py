"""Five primitive shapes, of which robots and simulated objects are made, and their measures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, TypeAlias

import coal
import numpy as np
import numpy.typing as npt
from pinocchio import SE3

Array: TypeAlias = npt.NDArray[np.float64]
Colour: TypeAlias = tuple[int, int, int]

GREY: Colour = (160, 160, 165)


@dataclass(frozen=True)
class Box:
    """A box centred on its frame."""

    half: tuple[float, float, float]
    """Half of the edge lengths along x, y and z [m]."""


@dataclass(frozen=True)
class Sphere:
    """A ball centred on its frame."""

    radius: float
    """[m]."""


@dataclass(frozen=True)
class Cylinder:
    """A cylinder centred on its frame, its axis along z."""

    radius: float
    """[m]."""
    half_length: float
    """From the centre to either flat end [m]."""


@dataclass(frozen=True)
class Capsule:
    """A cylinder with a half ball on each end, its axis along z."""

    radius: float
    """[m]."""
    half_length: float
    """From the centre to the centre of either half ball [m]."""


@dataclass(frozen=True)
class Plane:
    """The half-space below z = 0: an infinite floor, seen from above."""


Shape: TypeAlias = Box | Sphere | Cylinder | Capsule | Plane


@dataclass(frozen=True, eq=False)
class Geom:
    """A shape with a pose.

    Whoever holds it documents the frame of the pose: the world, an object, a link.
    """

    shape: Shape
    pose: SE3
    name: str = ""
    colour: Colour = GREY

    def moved(self, aTb: SE3) -> Geom:
        """The same shape seen from frame a, when `pose` is relative to frame b."""
        return Geom(self.shape, aTb * self.pose, self.name, self.colour)


def half_extents(shape: Shape) -> tuple[float, float, float]:
    """Half edge lengths of the box around a shape in its own frame [m]; infinite for a plane."""
    match shape:
        case Box(half):
            return half
        case Sphere(r):
            return (r, r, r)
        case Cylinder(r, length):
            return (r, r, length)
        case Capsule(r, length):
            return (r, r, length + r)
        case Plane():
            return (np.inf, np.inf, 0.0)


def bounding_radius(shape: Shape) -> float:
    """Radius of the ball around a shape, centred on its frame [m]; infinite for a plane."""
    match shape:
        case Sphere(r):
            return r
        case Capsule(r, length):
            return r + length
        case _:
            return float(np.linalg.norm(half_extents(shape)))


def rounded_box(shape: Shape) -> tuple[Array, float]:
    """A shape as all that is nearer to a box than a radius: half edge lengths (3,) and radius [m].

    A cylinder becomes the box around it, a plane one without end.
    """
    match shape:
        case Sphere(r):
            return np.zeros(3), r
        case Capsule(r, length):
            return np.array([0.0, 0.0, length]), r
        case _:
            return np.array(half_extents(shape)), 0.0


def from_rounded_boxes(points: Array, half: Array, radius: Array | float) -> tuple[Array, Array]:
    """How far points are from rounded boxes, each from its own or all from one.

    Args:
        points: (N, 3) in the frames of the boxes [m].
        half: (N, 3) or (3,) half edge lengths [m].
        radius: (N,) or one [m].

    Returns:
        Distances (N,) [m], negative inside, and the directions (N, 3) in which they grow.
    """
    away = points - np.clip(points, -half, half)
    distance: Array = np.linalg.norm(away, axis=1)
    direction = away / np.maximum(distance, 1e-12)[:, None]
    (inside,) = np.nonzero(distance == 0.0)
    if len(inside):
        within = points[inside]
        beyond = np.abs(within) - np.broadcast_to(half, points.shape)[inside]
        face, rows = beyond.argmax(axis=1), np.arange(len(inside))
        distance[inside] = beyond[rows, face]
        direction[inside, face] = np.where(within[rows, face] < 0.0, -1.0, 1.0)
    return distance - radius, direction


def reach(placed: Geom, direction: Array) -> float:
    """How far a bounded shape reaches along a unit direction (3,), both in its pose's frame [m]."""
    x, y, z = placed.pose.rotation.T @ direction
    match placed.shape:
        case Box((a, b, c)):
            beyond_centre = abs(x) * a + abs(y) * b + abs(z) * c
        case Sphere(r):
            beyond_centre = r
        case Cylinder(r, length):
            beyond_centre = r * float(np.hypot(x, y)) + length * abs(z)
        case Capsule(r, length):
            beyond_centre = r + length * abs(z)
        case Plane():
            raise ValueError("a plane has no bounds")
    return float(direction @ placed.pose.translation + beyond_centre)


def volume(shape: Shape) -> float:
    """Volume of a shape [m³]; infinite for a plane."""
    match shape:
        case Box((a, b, c)):
            return 8.0 * a * b * c
        case Sphere(r):
            return 4.0 / 3.0 * np.pi * r**3
        case Cylinder(r, length):
            return 2.0 * np.pi * r**2 * length
        case Capsule(r, length):
            return np.pi * r**2 * (2.0 * length + 4.0 / 3.0 * r)
        case Plane():
            return np.inf


@cache
def coal_geometry(shape: Shape) -> Any:
    """The `coal` geometry of a shape; made once for equal shapes."""
    match shape:
        case Box((x, y, z)):
            return coal.Box(2.0 * x, 2.0 * y, 2.0 * z)
        case Sphere(r):
            return coal.Sphere(r)
        case Cylinder(r, length):
            return coal.Cylinder(r, 2.0 * length)
        case Capsule(r, length):
            return coal.Capsule(r, 2.0 * length)
        case Plane():
            return coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)
