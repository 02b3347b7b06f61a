"""Schemas of poses, primitive shapes and inertias in robot files.

Poses are `xyz` [m] with either `rpy_deg`, roll, pitch and yaw about the fixed axes [deg], or
`rotation`, the rows of a rotation matrix. Without either they are not turned.
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

import numpy as np
import pinocchio as pin
from pinocchio import SE3
from pydantic import AfterValidator, Field, field_validator, model_validator

from config.reader import StrictModel
from robots.shapes import Array, Box, Capsule, Colour, Geom, Sphere, hull_of

# Bounds of all numbers, in SI units, degrees or pixels.
Finite: TypeAlias = Annotated[float, Field(ge=-1e4, le=1e4, allow_inf_nan=False)]
Positive: TypeAlias = Annotated[float, Field(ge=1e-6, le=1e4, allow_inf_nan=False)]
NotNegative: TypeAlias = Annotated[float, Field(ge=0.0, le=1e4, allow_inf_nan=False)]
_Moment: TypeAlias = Annotated[float, Field(ge=1e-9, le=1e4, allow_inf_nan=False)]


def _ordered(bounds: tuple[float, float]) -> tuple[float, float]:
    if bounds[0] >= bounds[1]:
        raise ValueError("the lower bound comes first")
    return bounds


Range: TypeAlias = Annotated[tuple[Finite, Finite], AfterValidator(_ordered)]
Vector: TypeAlias = tuple[Finite, Finite, Finite]

_ORTHONORMAL = 1e-6
_AXES = {
    "x": pin.utils.rotate("y", np.pi / 2.0),
    "y": pin.utils.rotate("x", np.pi / 2.0),
    "z": np.eye(3),
}
"""Rotations that turn z onto an axis."""


class PoseFile(StrictModel):
    """A pose."""

    xyz: Vector
    rpy_deg: Vector | None = None
    rotation: tuple[Vector, Vector, Vector] | None = None

    @field_validator("rotation")
    @classmethod
    def _is_a_rotation(cls, rows: tuple[Vector, ...] | None) -> tuple[Vector, ...] | None:
        if rows is not None:
            R = np.array(rows)
            if np.abs(R @ R.T - np.eye(3)).max() > _ORTHONORMAL or np.linalg.det(R) < 0.0:
                raise ValueError("the rows of a rotation matrix are orthonormal and right-handed")
        return rows

    @model_validator(mode="after")
    def _has_one_rotation(self) -> PoseFile:
        if self.rpy_deg is not None and self.rotation is not None:
            raise ValueError("give either `rpy_deg` or `rotation`")
        return self

    def pose(self) -> SE3:
        """The pose in SI units."""
        if self.rotation is not None:
            R = np.array(self.rotation)
        else:
            roll, pitch, yaw = np.deg2rad(self.rpy_deg or (0.0, 0.0, 0.0))
            rotate = pin.utils.rotate  # more exact in quarter turns than `rpyToMatrix`
            R = rotate("z", yaw) @ rotate("y", pitch) @ rotate("x", roll)
        return SE3(R, np.array(self.xyz))


class BoxFile(StrictModel):
    """A box along the axes of its frame."""

    xyz: Vector  # centre [m]
    size: tuple[Positive, Positive, Positive]  # edge lengths [m]

    def geom(self, name: str, colour: Colour) -> Geom:
        """The shape in its frame."""
        x, y, z = self.size
        half = (x / 2.0, y / 2.0, z / 2.0)
        return Geom(Box(half), SE3(np.eye(3), np.array(self.xyz)), name, colour)


class BallFile(StrictModel):
    """A ball."""

    xyz: Vector  # centre [m]
    radius: Positive

    def geom(self, name: str) -> Geom:
        """The shape in its frame."""
        return Geom(Sphere(self.radius), SE3(np.eye(3), np.array(self.xyz)), name)


class CapsuleFile(StrictModel):
    """A capsule."""

    xyz: Vector  # centre [m]
    axis: Literal["x", "y", "z"] | Vector  # or its direction
    radius: Positive
    length: NotNegative  # between the centres of the half balls [m]

    def geom(self, name: str) -> Geom:
        """The shape in its frame."""
        shape = Capsule(self.radius, self.length / 2.0)
        if isinstance(self.axis, str):
            return Geom(shape, SE3(_AXES[self.axis], np.array(self.xyz)), name)
        turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), np.array(self.axis))
        return Geom(shape, SE3(turn.matrix(), np.array(self.xyz)), name)


class HullFile(StrictModel):
    """The convex hull of points, in the frame of what it belongs to."""

    corners: Annotated[tuple[Vector, ...], Field(min_length=4)]  # [m]

    @field_validator("corners")
    @classmethod
    def _has_volume(cls, corners: tuple[Vector, ...]) -> tuple[Vector, ...]:
        hull_of(np.array(corners))
        return corners

    def geom(self, name: str) -> Geom:
        """The shape in its frame."""
        return hull_of(np.array(self.corners), name)


class InertiaFile(StrictModel):
    """Mass, centre of mass and inertia of a part."""

    mass: Positive  # [kg]
    xyz: Vector  # centre of mass [m]
    moments: tuple[_Moment, _Moment, _Moment]  # xx, yy, zz about that centre [kg m^2]
    products: Vector  # xy, xz and yz [kg m^2]

    @model_validator(mode="after")
    def _is_possible(self) -> InertiaFile:
        if np.linalg.eigvalsh(self._matrix())[0] <= 0.0:
            raise ValueError("no body has these `products` with these `moments`")
        return self

    def inertia(self) -> pin.Inertia:
        """The inertia in SI units."""
        return pin.Inertia(self.mass, np.array(self.xyz), self._matrix())

    def _matrix(self) -> Array:
        (xx, yy, zz), (xy, xz, yz) = self.moments, self.products
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
