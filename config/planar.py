"""Plane geometry: angles, points, and poses x [m], y [m], heading [rad] on the floor.

A pose is a `Pose2D`, or an array (3,) where it is estimated.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import atan2, cos, pi, sin
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from config.arrays import Array

if TYPE_CHECKING:
    from pinocchio import SE3

Number = TypeVar("Number", float, Array, npt.NDArray[np.floating])


def wrap(angle: Number) -> Number:
    """The same angle, or angles, in [-pi, pi) [rad]."""
    return (angle + pi) % (2.0 * pi) - pi


def rotate(angle: float | Array, x: Number, y: Number) -> tuple[Number, Number]:
    """The coordinates of vectors that are turned by an angle [rad]."""
    c, s = _cos_sin(angle)
    return c * x - s * y, s * x + c * y


def act(aTb: Iterable[float | Array], x: Number, y: Number) -> tuple[Number, Number]:
    """The coordinates in a of points in b, of a pose or of arrays of x, y and heading."""
    a, b, heading = aTb
    c, s = _cos_sin(heading)
    return a + c * x - s * y, b + s * x + c * y


def _cos_sin(angle: float | Array) -> tuple[Any, Any]:
    """Of numbers by `math`, which is quicker."""
    if isinstance(angle, float):
        return cos(angle), sin(angle)
    return np.cos(angle), np.sin(angle)


class Pose2D(NamedTuple):
    """A pose on the floor."""

    x: float  # [m]
    y: float  # [m]
    heading: float  # [rad]

    @classmethod
    def of(cls, oTb: SE3) -> Pose2D:
        """The pose on the floor of a pose in space."""
        (c, _, _, x), (s, _, _, y), _, _ = oTb.homogeneous.tolist()
        return cls(x, y, atan2(s, c))

    def relative_to(self, frame: Pose2D) -> Pose2D:
        """This pose in another frame; the heading in [-pi, pi)."""
        x, y = rotate(-frame.heading, self.x - frame.x, self.y - frame.y)
        return Pose2D(x, y, wrap(self.heading - frame.heading))

    def moved(self, x: float, y: float = 0.0, turn: float = 0.0) -> Pose2D:
        """After a motion in its own frame [m, rad]: straight, in the direction half-way."""
        there = act((self.x, self.y, self.heading + turn / 2.0), x, y)
        return Pose2D(*there, self.heading + turn)


ORIGIN = Pose2D(0.0, 0.0, 0.0)


def compose(aTb: Array, bTc: Array) -> Array:
    """The pose (3,) of c in a; the heading in [-pi, pi)."""
    here, (x, y, turn) = aTb.tolist(), bTc.tolist()
    return np.array([*act(here, x, y), wrap(here[2] + turn)])


def inverse(aTb: Array) -> Array:
    """The pose (3,) of a in b."""
    x, y, heading = aTb.tolist()
    return np.array([*rotate(-heading, -x, -y), -heading])


def difference(a: Array, b: Array) -> Array:
    """(3,) a - b of two poses, component by component; the heading in [-pi, pi)."""
    off = a - b
    off[2] = wrap(float(off[2]))
    return off


def about_z(angles: Array) -> Array:
    """Rotations (N, 3, 3) by angles (N,) [rad]."""
    c, s, zero = np.cos(angles), np.sin(angles), np.zeros(len(angles))
    return np.stack([c, -s, zero, s, c, zero, zero, zero, zero + 1.0], axis=1).reshape(-1, 3, 3)


def yaw_of(R: Array) -> float:
    """Angle about z by which a rotation (3, 3) turns the x axis [rad]."""
    return atan2(R[1, 0], R[0, 0])


def on_floor(aTb: SE3) -> Array:
    """The pose on the floor (3,) of a pose in space."""
    return np.array([*aTb.translation[:2], yaw_of(aTb.rotation)])


def in_space(aTb: Iterable[float]) -> SE3:
    """The pose in space, at height 0, of a pose on the floor."""
    from pinocchio import SE3  # which is slow to load, and loaded where there are poses in space

    x, y, heading = aTb
    c, s = cos(heading), sin(heading)
    return SE3(np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), np.array([x, y, 0.0]))
