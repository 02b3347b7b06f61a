"""What Frankie looks like, in primitives: enough to see where every part of it is."""

from __future__ import annotations

import numpy as np
from pinocchio import SE3, Quaternion

from robots import Box, Capsule, Colour, Cylinder, Geom

_WHITE: Colour = (225, 226, 230)
_SHELL: Colour = (190, 194, 200)
_DARK: Colour = (62, 66, 74)
_BLACK: Colour = (38, 40, 45)

_Point = tuple[float, float, float]

BASE_LENGTH, BASE_WIDTH = 0.70, 0.50
"""Of the base along x and y [m]."""


def _bar(start: _Point, end: _Point, radius: float, colour: Colour = _WHITE) -> Geom:
    """A capsule from point to point."""
    a, b = np.array(start), np.array(end)
    length = float(np.linalg.norm(b - a))
    turn = Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), (b - a) / length)
    return Geom(Capsule(radius, length / 2), SE3(turn, (a + b) / 2), colour=colour)


def _at(x: float, y: float, z: float) -> SE3:
    return SE3(np.eye(3), np.array([x, y, z]))


LINKS: tuple[tuple[Geom, ...], ...] = (
    (
        Geom(Cylinder(0.075, 0.03), _at(-0.02, 0.0, 0.03), colour=_DARK),
        _bar((0.0, 0.0, 0.06), (0.0, 0.0, 0.12), 0.062),
    ),
    (_bar((0.0, 0.0, -0.18), (0.0, 0.0, 0.0), 0.058),),
    (
        _bar((0.0, 0.0, -0.05), (0.0, 0.0, 0.05), 0.060, _SHELL),
        _bar((0.0, 0.0, 0.0), (0.0, -0.17, 0.0), 0.056),
    ),
    (
        _bar((0.0, 0.0, -0.12), (0.0, 0.0, -0.03), 0.055),
        _bar((0.0, 0.0, -0.03), (0.0825, 0.0, 0.0), 0.052),
    ),
    (
        _bar((0.0, 0.0, -0.05), (0.0, 0.0, 0.05), 0.058, _SHELL),
        _bar((0.0, 0.0, 0.0), (-0.0825, 0.10, 0.0), 0.052),
    ),
    (
        _bar((0.0, 0.0, -0.26), (0.0, 0.02, -0.16), 0.055),
        _bar((0.0, 0.05, -0.16), (0.0, 0.03, 0.0), 0.036),
    ),
    (
        _bar((0.0, 0.0, -0.04), (0.0, 0.0, 0.05), 0.050, _SHELL),
        _bar((0.0, 0.0, 0.0), (0.088, 0.0, 0.0), 0.048),
    ),
    (_bar((0.0, 0.0, -0.02), (0.0, 0.0, 0.06), 0.044),),
)
"""The arm's foot and seven links, each in its own frame."""

HAND: tuple[Geom, ...] = (Geom(Box((0.022, 0.102, 0.033)), _at(0.0, 0.0, 0.033), colour=_WHITE),)
"""The hand, in the flange's frame."""
CAMERA = Geom(Box((0.012, 0.045, 0.012)), _at(0.065, 0.0, 0.012), colour=_BLACK)
"""The camera on it, in the same frame."""

_HALF_TURN = SE3(np.diag([-1.0, -1.0, 1.0]), np.zeros(3))
_FINGER = Box((0.010, 0.007, 0.026))
_FINGER_ROOT = 0.0584
"""Of a finger, in the hand along z [m]."""
FINGER_MIDDLE = (0.0, _FINGER.half[1], 0.0274)
"""Of a finger, from its root at the inner face of its pad [m]."""


def finger_poses(width: float) -> tuple[SE3, SE3]:
    """Left and right finger in the hand, with `width` [m] between the pads."""
    left = _at(0.0, width / 2 + FINGER_MIDDLE[1], _FINGER_ROOT + FINGER_MIDDLE[2])
    return left, _HALF_TURN * left


FINGER = (Geom(_FINGER, SE3.Identity(), colour=_DARK),)
"""One finger, in its own frame."""


def base_parts(height: float) -> tuple[Geom, ...]:
    """The mobile base up to the arm's foot, `height` [m] above the floor, in the base's frame."""
    half = (BASE_LENGTH / 2, BASE_WIDTH / 2, height / 2 - 0.03)
    lid = (BASE_LENGTH / 2 - 0.02, BASE_WIDTH / 2 - 0.02, 0.01)
    nose = (0.01, BASE_WIDTH / 2 - 0.08, 0.02)
    return (
        Geom(Box(half), _at(0.0, 0.0, height / 2 + 0.01), colour=_DARK),
        Geom(Box(lid), _at(0.0, 0.0, height - 0.01), colour=_SHELL),
        Geom(Box(nose), _at(BASE_LENGTH / 2, 0.0, height * 0.6), colour=(245, 170, 40)),
    )
