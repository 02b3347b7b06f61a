"""Shapes as ROS markers that move with the frame of their body."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from pinocchio import SE3, Quaternion

from robots import Box, Capsule, Cylinder, Geom, Hull, Sphere

CUBE, SPHERE, CYLINDER, _TRIANGLES = 1, 2, 3, 11  # kinds of visualization_msgs/Marker


def xyz(values: Any) -> dict[str, float]:
    """A vector or point of three numbers."""
    return dict(zip("xyz", map(float, values), strict=True))


def rotation(pose: SE3) -> dict[str, float]:
    """The quaternion of a pose."""
    return dict(zip("xyzw", Quaternion(pose.rotation).coeffs().tolist(), strict=True))


def posed(pose: SE3) -> dict[str, Any]:
    """A pose."""
    return {"position": xyz(pose.translation), "orientation": rotation(pose)}


def markers(group: str, frame: str, bodies: Iterable[Geom]) -> Iterator[dict[str, Any]]:
    """Markers of shapes in a frame, without numbers; none of planes."""
    for body in bodies:
        colour = dict(zip("rgb", np.array(body.colour) / 255.0, strict=True))
        for kind, pose, scale, corners in _primitives(body):
            yield {
                "header": {"frame_id": frame},
                "ns": group,
                "type": kind,
                "pose": posed(pose),
                "scale": xyz(scale),
                "color": colour | {"a": 1.0},
                "frame_locked": True,
                "points": [xyz(corner) for corner in corners],
            }


def _primitives(body: Geom) -> Iterator[tuple[int, SE3, Any, Any]]:
    """Kind, pose, scale [m] and corners of the markers of a shape."""
    match body.shape:
        case Box(half=half):
            yield CUBE, body.pose, 2.0 * np.array(half), ()
        case Sphere(radius=r):
            yield SPHERE, body.pose, (2 * r, 2 * r, 2 * r), ()
        case Cylinder(radius=r, half_length=h):
            yield CYLINDER, body.pose, (2 * r, 2 * r, 2 * h), ()
        case Capsule(radius=r, half_length=h):
            yield CYLINDER, body.pose, (2 * r, 2 * r, 2 * h), ()
            for z in (-h, h):
                end = body.pose * SE3(np.eye(3), np.array([0.0, 0.0, z]))
                yield SPHERE, end, (2 * r, 2 * r, 2 * r), ()
        case Hull(vertices=vertices, triangles=triangles):
            yield _TRIANGLES, body.pose, (1, 1, 1), vertices[triangles.ravel()]
