"""Bodies and shapes in a MuJoCo specification."""

from enum import IntFlag
from typing import Any

import mujoco
import numpy as np
from pinocchio import SE3, Inertia, Quaternion

from robots import Array, Box, Capsule, Cylinder, Geom, Hull, Plane, Shape, Sphere

_HARD = (0.006, 1.0)  # time constant [s] and damping ratio; a pair has the mean
_SOLIMP = (0.95, 0.99, 0.0005, 0.5, 2.0)  # nearly rigid from half a millimetre on
_TORSION, _ROLLING = 0.005, 0.0005  # radii of torsional and rolling friction [m]


class Kind(IntFlag):
    """Contact types (MuJoCo's contype bits)."""

    FIXTURE = 1
    FLOOR = 2
    WALKER = 4
    OBJECT = 8


ALL = sum(Kind)


def add_body(parent: Any, name: str, pose: SE3) -> Any:
    """A body on another one, at a pose in its frame."""
    return parent.add_body(name=name, pos=pose.translation, quat=quaternion(pose))


def weigh(body: Any, inertia: Inertia) -> None:
    """Set the inertia of a body, instead of that of its shapes."""
    i = inertia.inertia
    body.explicitinertial = True
    body.mass, body.ipos = inertia.mass, inertia.lever
    body.fullinertia = (i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2])


def add_geom(
    spec: Any, body: Any, geom: Geom, name: str, kind: int, against: int, friction: float
) -> Any:
    """A shape on a body: its contact type, and those that it collides with."""
    return body.add_geom(
        **_shape(spec, geom.shape, name),
        name=name,
        pos=geom.pose.translation,
        quat=quaternion(geom.pose),
        contype=kind,
        conaffinity=against,
        condim=4,
        friction=(friction, _TORSION, _ROLLING),
        solref=_HARD,
        solimp=_SOLIMP,
        mass=0.0,
    )


def _shape(spec: Any, shape: Shape, name: str) -> dict[str, Any]:
    types = mujoco.mjtGeom
    match shape:
        case Box(half):
            return {"type": types.mjGEOM_BOX, "size": half}
        case Sphere(r):
            return {"type": types.mjGEOM_SPHERE, "size": (r, 0.0, 0.0)}
        case Cylinder(r, length):
            return {"type": types.mjGEOM_CYLINDER, "size": (r, length, 0.0)}
        case Capsule(r, length):
            return {"type": types.mjGEOM_CAPSULE, "size": (r, length, 0.0)}
        case Hull(vertices, triangles):
            spec.add_mesh(name=name, uservert=vertices.ravel(), userface=triangles.ravel())
            return {"type": types.mjGEOM_MESH, "meshname": name}
        case Plane():
            return {"type": types.mjGEOM_PLANE, "size": (0.0, 0.0, 1.0)}


def quaternion(pose: SE3) -> Array:
    """(4,) the rotation of a pose: w, x, y, z."""
    x, y, z, w = Quaternion(pose.rotation).coeffs()
    return np.array([w, x, y, z])
