"""Rerun archetypes of shapes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import rerun as rr
from pinocchio import Quaternion

from robots import Box, Capsule, Cylinder, Geom, Hull, Sphere


def solids(parts: Sequence[Geom], fill: str = "solid") -> list[Any]:
    """Archetypes of shapes in the frame of their poses, with Rerun's fill mode; no planes."""
    bodies: list[Any] = []
    for kind, made in (
        (Box, _boxes),
        (Sphere, _balls),
        (Cylinder, _cylinders),
        (Capsule, _capsules),
    ):
        if some := [part for part in parts if isinstance(part.shape, kind)]:
            looks = {
                "quaternions": [Quaternion(part.pose.rotation).coeffs() for part in some],
                "colors": [part.colour for part in some],
                "fill_mode": fill,
            }
            bodies.append(made([(part.shape, part.pose) for part in some], looks))
    if hulls := [part for part in parts if isinstance(part.shape, Hull)]:
        bodies.append(_one_mesh(hulls))
    return bodies


def _boxes(parts: list[Any], looks: dict[str, Any]) -> Any:
    sizes = [box.half for box, _ in parts]
    return rr.Boxes3D(half_sizes=sizes, centers=_centres(parts), **looks)


def _balls(parts: list[Any], looks: dict[str, Any]) -> Any:
    return rr.Ellipsoids3D(
        radii=[ball.radius for ball, _ in parts], centers=_centres(parts), **looks
    )


def _cylinders(parts: list[Any], looks: dict[str, Any]) -> Any:
    return rr.Cylinders3D(**_radii_and_lengths(parts), centers=_centres(parts), **looks)


def _capsules(parts: list[Any], looks: dict[str, Any]) -> Any:
    ends = [pose.act(np.array([0.0, 0.0, -capsule.half_length])) for capsule, pose in parts]
    return rr.Capsules3D(**_radii_and_lengths(parts), translations=ends, **looks)


def _one_mesh(hulls: Sequence[Geom]) -> Any:
    shapes: list[Any] = [(part.shape, part.pose, part.colour) for part in hulls]
    corners = [
        (hull.vertices @ pose.rotation.T + pose.translation)[hull.triangles.ravel()]
        for hull, pose, _ in shapes
    ]
    faces = np.concatenate(corners).reshape(-1, 3, 3)
    a, b, c = faces.transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    colours = [np.tile(colour, (hull.triangles.size, 1)) for hull, _, colour in shapes]
    return rr.Mesh3D(
        vertex_positions=faces.reshape(-1, 3),
        vertex_normals=np.repeat(normals, 3, axis=0),
        vertex_colors=np.concatenate(colours),
    )


def _centres(parts: list[Any]) -> list[Any]:
    return [pose.translation for _, pose in parts]


def _radii_and_lengths(parts: list[Any]) -> dict[str, Any]:
    return {
        "radii": [shape.radius for shape, _ in parts],
        "lengths": [2 * shape.half_length for shape, _ in parts],
    }
