"""Primitive shapes and convex hulls of robots and objects, and their measures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from itertools import product
from typing import Any, TypeAlias

import coal
import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from config.arrays import Array

Triangles: TypeAlias = npt.NDArray[np.int32]
Colour: TypeAlias = tuple[int, int, int]

GREY: Colour = (160, 160, 165)
CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))  # (8, 3) of the cube of half edge 1


@dataclass(frozen=True)
class Box:
    """A box centred on its frame."""

    half: tuple[float, float, float]  # half of the edge lengths along x, y and z [m]


@dataclass(frozen=True)
class Sphere:
    """A ball centred on its frame."""

    radius: float  # [m]


@dataclass(frozen=True)
class Cylinder:
    """A cylinder centred on its frame, its axis along z."""

    radius: float  # [m]
    half_length: float  # from the centre to either flat end [m]


@dataclass(frozen=True)
class Capsule:
    """A cylinder with a half ball on each end, its axis along z."""

    radius: float  # [m]
    half_length: float  # from the centre to the centre of either half ball [m]


@dataclass(frozen=True, eq=False)
class Hull:
    """A convex polyhedron, made by `hull_of`, its bounding box centred on its frame."""

    vertices: Array  # (V, 3) corners [m]
    triangles: Triangles  # (T, 3) corners of its faces, counter-clockwise seen from outside

    @cached_property
    def half(self) -> tuple[float, float, float]:
        """Half edge lengths of its bounding box [m]."""
        x, y, z = np.abs(self.vertices).max(axis=0).tolist()
        return (x, y, z)

    @cached_property
    def radius(self) -> float:
        """Of the ball around it, centred on its frame [m]."""
        return float(np.linalg.norm(self.vertices, axis=1).max())


@dataclass(frozen=True)
class Plane:
    """The half-space below z = 0: an infinite floor, seen from above."""


Shape: TypeAlias = Box | Sphere | Cylinder | Capsule | Hull | Plane


@dataclass(frozen=True, eq=False)
class Geom:
    """A shape with a pose, in the frame that its owner documents."""

    shape: Shape
    pose: SE3
    name: str = ""
    colour: Colour = GREY

    @property
    def piece(self) -> str:
        """The piece of furniture that it belongs to: the part of its name before `/`."""
        return self.name.partition("/")[0]

    def moved(self, aTb: SE3) -> Geom:
        """The same shape seen from frame a, when `pose` is relative to frame b."""
        return Geom(self.shape, aTb * self.pose, self.name, self.colour)


def hull_of(points: Array, name: str = "", colour: Colour = GREY) -> Geom:
    """The convex hull of (N, 3) points, posed in their frame [m]; ValueError: they are flat."""
    from scipy.spatial import ConvexHull, QhullError  # slow to import

    try:
        hull = ConvexHull(points)
    except QhullError as error:
        raise ValueError("the points have no volume between them") from error
    vertices, flat = np.unique(hull.simplices, return_inverse=True)
    corners = points[vertices]
    triangles = flat.reshape(-1, 3).astype(np.int32)
    a, b, c = corners[triangles].transpose(1, 0, 2)
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    triangles[inwards] = triangles[inwards][:, ::-1]
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2.0
    return Geom(Hull(corners - middle, triangles), SE3(np.eye(3), middle), name, colour)


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
        case Hull():
            return shape.half
        case Plane():
            return (np.inf, np.inf, 0.0)


def bounding_radius(shape: Shape) -> float:
    """Radius of the ball around a shape, centred on its frame [m]; infinite for a plane."""
    match shape:
        case Sphere(r):
            return r
        case Capsule(r, length):
            return r + length
        case Hull():
            return shape.radius
        case _:
            return float(np.linalg.norm(half_extents(shape)))


def rounded_box(shape: Shape) -> tuple[Array, float]:
    """Half edges (3,) and radius of the rounded box around a shape [m]; exact but for cylinders."""
    match shape:
        case Sphere(r):
            return np.zeros(3), r
        case Capsule(r, length):
            return np.array([0.0, 0.0, length]), r
        case _:
            return np.array(half_extents(shape)), 0.0


def from_rounded_boxes(points: Array, half: Array, radius: Array | float) -> tuple[Array, Array]:
    """Signed distances (N,) of points (N, 3) to rounded boxes [m], and gradients (N, 3)."""
    away = points - np.minimum(np.maximum(points, -half), half)
    distance: Array = np.sqrt((away * away).sum(axis=1))
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
    """Support of a bounded shape along a unit direction (3,), both in its pose's frame [m]."""
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
        case Hull(vertices):
            beyond_centre = float((vertices @ np.array([x, y, z])).max())
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
        case Hull(vertices, triangles):
            return float(np.linalg.det(vertices[triangles]).sum()) / 6.0
        case Plane():
            return np.inf


def centroid(shape: Shape) -> Array:
    """Centre of mass (3,) of a shape in its own frame [m]."""
    if not isinstance(shape, Hull):
        return np.zeros(3)
    corners = shape.vertices[shape.triangles]
    wedges = np.linalg.det(corners)
    middle: Array = wedges @ corners.sum(axis=1) / (4.0 * wedges.sum())
    return middle


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
        case Hull(vertices, triangles):
            points, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
            points.extend(vertices)
            faces.extend(coal.Triangle(*corners) for corners in triangles.tolist())
            return coal.Convex(points, faces)
        case Plane():
            return coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)
