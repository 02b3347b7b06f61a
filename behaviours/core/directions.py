"""Directions of approach: how the hand comes to a place and leaves it, straight down to level."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, atan2, pi, radians
from typing import Literal, TypeAlias

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from config.arrays import Array
from config.planar import yaw_of
from config.poses import OdometryFromMap

ApproachWord: TypeAlias = Literal["auto", "down", "tilted", "level"]
"""Of directions: any, straight down, 15 to 75 degrees of tilt, 75 degrees or more."""

_STRAIGHT = radians(8.0)  # a hand that is tilted by less points straight down [rad]
_LEAST_RISE = 0.2  # share of the way out that leads up, at least


@dataclass(frozen=True)
class Direction:
    """A direction in which the hand points."""

    tilt: float
    """From straight down [rad]."""
    heading: float
    """Of the tilt, from the x axis of the map [rad]."""

    @property
    def is_straight(self) -> bool:
        """Whether it is straight down."""
        return self.tilt < _STRAIGHT

    @property
    def rotation(self) -> Array:
        """(3, 3) mRa: of axes that are upright for a hand that points down.

        z is against the approach, x in the upright plane of the tilt.
        """
        turned: Array = pin.utils.rotate("z", self.heading) @ pin.utils.rotate("y", -self.tilt)
        return turned

    @property
    def hand(self) -> Array:
        """(3, 3) of a hand on the map that points there, its x axis up or ahead."""
        return self.rotation @ np.diag([1.0, -1.0, -1.0])

    def turned(self, oTm: OdometryFromMap) -> Direction:
        """The same in odometry."""
        return Direction(self.tilt, self.heading + yaw_of(oTm.rotation))


DOWN = Direction(0.0, 0.0)


def tilt_of(oRe: Array) -> float:
    """Angle between the approach of a hand and straight down [rad]."""
    return acos(float(np.clip(-oRe[2, 2], -1.0, 1.0)))


def points_down(oRe: Array) -> bool:
    """Whether a hand counts as pointing straight down."""
    return tilt_of(oRe) < _STRAIGHT


def looking_down(x_axis: Array) -> Array:
    """(3, 3) rotation with z down and the heading of an x axis (3,), in odometry."""
    down: Array = pin.rpy.rpyToMatrix(pi, 0.0, atan2(x_axis[1], x_axis[0]))
    return down


def heading_of(oRe: Array) -> float:
    """Direction in which a tilted hand points, from the world's x axis [rad]."""
    return atan2(oRe[1, 2], oRe[0, 2])


def way_out(oRe: Array) -> Array:
    """(3,) unit vector in odometry, in which a hand leaves what it has come to.

    Straight up, or back the way it came, rising a little.
    """
    up = np.array([0.0, 0.0, 1.0])
    if points_down(oRe):
        return up
    back = -oRe[:, 2]
    back = back + max(0.0, _LEAST_RISE - back[2]) * up
    out: Array = back / np.linalg.norm(back)
    return out


def upright(grasp: SE3 | None, now: Array, way_in: Direction) -> Array:
    """(3, 3) of the hand in odometry with which what it holds stands as it has stood.

    Args:
        grasp: hand when it gripped, in odometry; None if that is not known.
        now: (3, 3) of the hand, whose turn about the vertical is kept where any will do.
        way_in: where it points, if it must be tilted, in odometry.
    """
    if grasp is None or points_down(grasp.rotation):
        return looking_down(now[:, 0])
    heading = heading_of(now) if way_in.is_straight else way_in.heading
    turned: Array = pin.utils.rotate("z", heading - heading_of(grasp.rotation)) @ grasp.rotation
    return turned
