"""The Franka hand as boxes: a palm, two fingers and their pads.

Everything is in the end-effector frame e, the grasp centre between the finger tips: z along the
approach, y the closing direction. The left finger is the one on the side of +y.
"""

from __future__ import annotations

import numpy as np
from pinocchio import SE3

from robots.shapes import Box, Geom

TIP = 0.008
"""How far the pads reach beyond the grasp centre along the approach [m]."""

SIDES = {"left": 1.0, "right": -1.0}
"""The side along y on which each finger is."""

_PALM = Box((0.0316, 0.1020, 0.0460))
_PALM_Z = -0.0829
_FINGER = Box((0.01025, 0.00725, 0.0180))
_FINGER_Z = -0.0270
_FINGER_BEHIND = 0.0085
_PAD = Box((0.0085, 0.0040, TIP + 0.0005))
_PAD_Z = -0.0005

CENTRE = np.array([0.0, 0.0, -0.05])
"""(3,) centre, in e, of a ball around the hand [m] ..."""
RADIUS = 0.14
"""... and its radius, at any opening [m]."""

_METAL = (225, 225, 228)
_RUBBER = (40, 40, 44)


def pad(wTe: SE3, side: str, from_centre: float) -> Geom:
    """The pad of the `left` or `right` finger, its face `from_centre` [m] from the grasp centre."""
    y = SIDES[side] * (from_centre + _PAD.half[1])
    return Geom(_PAD, wTe * _shifted(y, _PAD_Z), f"{side} pad", _RUBBER)


def hand_shapes(wTe: SE3, width: float) -> list[Geom]:
    """The whole hand in the world.

    Args:
        wTe: end effector in the world.
        width: distance between the pads [m].
    """
    shapes = [Geom(_PALM, wTe * _shifted(0.0, _PALM_Z), "palm", _METAL)]
    for side, sign in SIDES.items():
        y = sign * (width / 2.0 + _FINGER_BEHIND)
        shapes.append(Geom(_FINGER, wTe * _shifted(y, _FINGER_Z), f"{side} finger", _METAL))
        shapes.append(pad(wTe, side, width / 2.0))
    return shapes


def _shifted(y: float, z: float) -> SE3:
    return SE3(np.eye(3), np.array([0.0, y, z]))
