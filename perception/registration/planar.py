"""Poses on the floor as arrays (3,): x [m], y [m], heading [rad]."""

from __future__ import annotations

from math import atan2, cos, pi, sin
from typing import TypeVar

import numpy as np
from pinocchio import SE3

from perception.frame import Array

Angle = TypeVar("Angle", float, Array)


def wrap(angle: Angle) -> Angle:
    """The same angle, or angles, in [-pi, pi) [rad]."""
    return (angle + pi) % (2.0 * pi) - pi


def compose(aTb: Array, bTc: Array) -> Array:
    """The pose (3,) of c in a; the heading in [-pi, pi)."""
    c, s = cos(aTb[2]), sin(aTb[2])
    x, y, heading = bTc
    turned = wrap(float(aTb[2] + heading))
    return np.array([aTb[0] + c * x - s * y, aTb[1] + s * x + c * y, turned])


def inverse(aTb: Array) -> Array:
    """The pose (3,) of a in b."""
    c, s = cos(aTb[2]), sin(aTb[2])
    x, y, heading = aTb
    return np.array([-c * x - s * y, s * x - c * y, -heading])


def difference(a: Array, b: Array) -> Array:
    """(3,) a - b of two poses, component by component; the heading in [-pi, pi)."""
    off = a - b
    off[2] = wrap(float(off[2]))
    return off


def on_floor(aTb: SE3) -> Array:
    """The pose on the floor (3,) of a pose in space."""
    R = aTb.rotation
    return np.array([*aTb.translation[:2], atan2(R[1, 0], R[0, 0])])


def in_space(aTb: Array) -> SE3:
    """The pose in space, at height 0, of a pose on the floor (3,)."""
    c, s = cos(aTb[2]), sin(aTb[2])
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return SE3(R, np.array([aTb[0], aTb[1], 0.0]))
