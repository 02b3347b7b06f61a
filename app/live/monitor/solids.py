"""Rerun archetypes of shapes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np
import rerun as rr

from app.live.monitor.columns import quaternion
from robots import Box, Capsule, Cylinder, Geom, Hull, Shape, Sphere

AnyShape = TypeVar("AnyShape", bound=Shape)


def solids(parts: Sequence[Geom], fill: str = "solid") -> list[Any]:
    """Archetypes of shapes in the frame of their poses, with Rerun's fill mode; no planes."""
    bodies: list[Any] = []
    if boxes := _of_type(parts, Box):
        half_sizes = [box.half for _, box in boxes]
        bodies.append(
            rr.Boxes3D(half_sizes=half_sizes, centers=_centres(boxes), **_looks(boxes, fill))
        )
    if balls := _of_type(parts, Sphere):
        radii = [ball.radius for _, ball in balls]
        bodies.append(rr.Ellipsoids3D(radii=radii, centers=_centres(balls), **_looks(balls, fill)))
    if cylinders := _of_type(parts, Cylinder):
        sizes = _radii_and_lengths(cylinders)
        bodies.append(
            rr.Cylinders3D(**sizes, centers=_centres(cylinders), **_looks(cylinders, fill))
        )
    if capsules := _of_type(parts, Capsule):
        sizes = _radii_and_lengths(capsules)
        ends = [
            part.pose.act(np.array([0.0, 0.0, -capsule.half_length])) for part, capsule in capsules
        ]
        bodies.append(rr.Capsules3D(**sizes, translations=ends, **_looks(capsules, fill)))
    if hulls := _of_type(parts, Hull):
        bodies.append(_one_mesh(hulls))
    return bodies


def _one_mesh(hulls: Sequence[tuple[Geom, Hull]]) -> Any:
    corners = [
        (hull.vertices @ part.pose.rotation.T + part.pose.translation)[hull.triangles.ravel()]
        for part, hull in hulls
    ]
    colours = [np.tile(part.colour, (hull.triangles.size, 1)) for part, hull in hulls]
    faces = np.concatenate(corners).reshape(-1, 3, 3)
    a, b, c = faces.transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return rr.Mesh3D(
        vertex_positions=faces.reshape(-1, 3),
        vertex_normals=np.repeat(normals, 3, axis=0),
        vertex_colors=np.concatenate(colours),
    )


def _of_type(parts: Sequence[Geom], shape: type[AnyShape]) -> list[tuple[Geom, AnyShape]]:
    return [(part, part.shape) for part in parts if isinstance(part.shape, shape)]


def _centres(bodies: Sequence[tuple[Geom, Any]]) -> list[Any]:
    return [part.pose.translation for part, _ in bodies]


def _radii_and_lengths(
    bodies: Sequence[tuple[Geom, Cylinder]] | Sequence[tuple[Geom, Capsule]],
) -> dict[str, Any]:
    return {
        "radii": [shape.radius for _, shape in bodies],
        "lengths": [2 * shape.half_length for _, shape in bodies],
    }


def _looks(bodies: Sequence[tuple[Geom, Any]], fill: str) -> dict[str, Any]:
    return {
        "quaternions": [quaternion(part.pose) for part, _ in bodies],
        "colors": [part.colour for part, _ in bodies],
        "fill_mode": fill,
    }
