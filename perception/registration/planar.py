"""Poses on the floor as arrays (3,): x [m], y [m], heading [rad]."""

from math import atan2, cos, hypot, pi, radians, sin
from typing import TypeVar

import numpy as np
from pinocchio import SE3

from perception.frame import Array

Angle = TypeVar("Angle", float, Array)

_SPEED, _TURN = 0.2, radians(12.0)  # at which the pose of the base is corrected [m/s, rad/s]


def wrap(angle: Angle) -> Angle:
    """The same angle, or angles, in [-pi, pi) [rad]."""
    return (angle + pi) % (2.0 * pi) - pi


def compose(aTb: Array, bTc: Array) -> Array:
    """The pose (3,) of c in a; the heading in [-pi, pi)."""
    (a, b, heading), (x, y, turn) = aTb.tolist(), bTc.tolist()
    c, s = cos(heading), sin(heading)
    return np.array([a + c * x - s * y, b + s * x + c * y, wrap(heading + turn)])


def inverse(aTb: Array) -> Array:
    """The pose (3,) of a in b."""
    x, y, heading = aTb.tolist()
    c, s = cos(heading), sin(heading)
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
    x, y, heading = aTb.tolist()
    c, s = cos(heading), sin(heading)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return SE3(R, np.array([x, y, 0.0]))


def smoothed(applied: Array, newest: Array, oTb: Array, dt: float) -> Array:
    """`mTo` (3,) a period later, on its way to the newest estimate without a step at the base.

    Args:
        applied: (3,) mTo of the last period.
        newest: (3,) mTo of the estimate.
        oTb: (3,) odometry now.
        dt: period [s].
    """
    mTb = compose(applied, oTb)
    off = difference(compose(newest, oTb), mTb)
    most = max(hypot(off[0], off[1]) / (_SPEED * dt), abs(float(off[2])) / (_TURN * dt), 1.0)
    return compose(mTb + off / most, inverse(oTb))
