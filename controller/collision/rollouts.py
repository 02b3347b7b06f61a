"""Rollouts of the base, seen from above, and how near they come to what moves."""

from __future__ import annotations

from math import hypot
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from controller.command import Array
from controller.floor import Pose2D
from controller.model import RobotModel
from controller.surroundings import Obstacle
from robots import Box, Hull, Shape, half_extents

HORIZON = 2.7
"""How far the courses of base and obstacle are led on [s]."""
MARGIN = 0.10
"""What the base wants to keep from what moves [m]."""
STOPPING = 3
"""How many courses of every velocity, the first ones, end with a stop."""
_LENGTHS = np.array([0.1] * 10 + [0.2125] * 8)
"""Of the steps of a course [s]: what is near is looked at more often."""
_KEPT = np.array([0.15, 0.5, HORIZON, 0.6, 1.3])
"""How long a velocity is kept [s]; then the base stops, or after the last ones goes where it is
led."""
_MISSING = 80.0
"""What it costs to miss all of the margin: to miss half of it costs little."""
_PER_SPEED = 0.1
"""More of the margin per speed of what moves [s]."""
_BEHIND = 0.04
"""To where it is now, if the base stops at once [m]."""
_TOUCH = 80.0
"""What a contact costs per speed with which the base comes nearer [s/m] ..."""
_DEEP = 240.0
"""... and per `MARGIN` of its depth."""
_BRAKING = 0.8
"""Share of the acceleration limits that is relied on."""
_ARM = 0.08
"""The arm is no farther than this from the points that stand for it [m]."""
_ARM_POINTS = (0, 4, 6, 7, 8)
"""Of the arm's foot, links and hand: where it bends."""


class MovingScene(NamedTuple):
    """What moves, and from where it is seen."""

    wTb: Pose2D
    """Base pose."""
    arm: Array
    """(K, 2) points that stand for the arm, in the base frame [m]."""
    obstacles: list[Obstacle]


class Rollouts:
    """Leads velocities of one robot's base on.

    Args:
        model: the robot.
    """

    def __init__(self, model: RobotModel) -> None:
        self._axes = model.description.base.axes
        length, width, _ = model.description.base.size
        self._half = np.array([length, width]) / 2.0
        self._acceleration = _BRAKING * model.acceleration_limits[: model.n_base]
        self._times = np.cumsum(_LENGTHS)
        self._middles = self._times - _LENGTHS / 2.0 - model.description.base.lag

    def of(self, now: Array, velocities: Array, led: Array) -> Array:
        """Poses (V, T, K, 3) in the base frame of now.

        Args:
            now: (n_base,) velocity of the base.
            velocities: (V, n_base) what it keeps for a while.
            led: (n_base,) its velocity after that on the last courses; on the first `STOPPING` of
                each it stops.
        """
        t, a = self._middles[:, None], self._acceleration
        kept = _KEPT[:, None, None]
        later = np.zeros((len(kept), 1, len(led)))
        later[STOPPING:] = led

        def changed(start: Array, end: Array, time: Array) -> Array:
            limit = a * np.maximum(time, 0.0)
            return np.asarray(start + np.clip(end - start, -limit, limit))

        there = changed(now, velocities[:, None, None], np.minimum(t, kept))
        twists = (changed(there, later, t - kept) @ self._axes.T) * _LENGTHS[:, None]
        headings = np.cumsum(twists[..., 2], axis=-1)
        middle = headings - twists[..., 2] / 2.0
        c, s = np.cos(middle), np.sin(middle)
        x = np.cumsum(c * twists[..., 0] - s * twists[..., 1], axis=-1)
        y = np.cumsum(s * twists[..., 0] + c * twists[..., 1], axis=-1)
        return np.stack([x, y, headings], axis=-1)

    def missing(self, courses: Array, sight: MovingScene, margin: float) -> Array:
        """(V, T) what it costs that courses (V, T, K, 3) come too near to what moves."""
        wTb = sight.wTb
        arm = sight.arm
        missing = np.zeros(courses.shape[:2])
        c, s = np.cos(wTb.heading), np.sin(wTb.heading)
        turn = np.array([[c, -s], [s, c]])
        for one in sight.obstacles:
            centre = (one.geom.pose.translation[:2] - [wTb.x, wTb.y]) @ turn
            velocity, own = one.velocity[:2] @ turn, radius(one.geom.shape)
            wide = margin + _PER_SPEED * hypot(*velocity.tolist())
            d = self._distance(courses, centre + self._times[:, None] * velocity, arm) - own
            # Whoever walks may stop: the base, too, must be able to, at once.
            stops = self._distance(courses[:, :1], centre[None], arm) - own
            here = float(self._distance(np.zeros(3), centre, arm)) - own
            close = np.maximum(min(_BEHIND, here) - stops.min(axis=-1), 0.0) / MARGIN
            short = np.clip(wide - d.min(axis=-1), 0.0, wide) / wide
            missing += _MISSING * (short**4 + close**2)
            missing += self._contact(courses, d, centre + self._times[:, None] * velocity, arm, own)
        return missing

    def _contact(self, courses: Array, d: Array, path: Array, arm: Array, own: float) -> Array:
        """(V, T) what contact costs: by the speed of approach where it begins, and by its depth.

        `d` (V, T, K) is the distance to what goes along `path` (K, 2), of radius `own`.
        """
        inside = d < 0.0
        if not inside.any():
            return np.zeros(d.shape[:-1])
        first = np.maximum(inside.argmax(axis=-1), 1)
        before = np.take_along_axis(courses, first[..., None, None] - 1, 2)[:, :, 0]
        at_first = np.take_along_axis(d, first[..., None], 2)[..., 0]
        closing = self._distance(before, path[first], arm) - own - at_first
        closing = np.maximum(closing, 0.0) / _LENGTHS[first]
        cost = _TOUCH * closing - _DEEP * d.min(axis=-1) / MARGIN
        return np.where(inside.any(axis=-1), cost, 0.0)

    def _distance(self, courses: Array, there: Array, arm: Array) -> Array:
        """(...) distances of base poses (..., 3) and the arm to points (..., 2) [m]."""
        c, s = np.cos(courses[..., 2]), np.sin(courses[..., 2])
        dx, dy = there[..., 0] - courses[..., 0], there[..., 1] - courses[..., 1]
        x, y = c * dx + s * dy, c * dy - s * dx
        beyond_x, beyond_y = np.abs(x) - self._half[0], np.abs(y) - self._half[1]
        d = np.hypot(np.maximum(beyond_x, 0.0), np.maximum(beyond_y, 0.0))
        d += np.minimum(np.maximum(beyond_x, beyond_y), 0.0)
        for ax, ay in arm.tolist():
            d = np.minimum(d, np.hypot(x - ax, y - ay) - _ARM)
        return np.asarray(d)


def seen_from_above(model: RobotModel, q: Array) -> Array:
    """(K, 2) points that stand for the arm, in the base frame, for q (7,) [m]."""
    poses = model.link_poses(SE3.Identity(), q)
    bends = [poses[number].translation[:2] for number in _ARM_POINTS]
    bends.append(model.bTe(q).translation[:2])
    upper, fore = (bends[0] + bends[1]) / 2.0, (bends[1] + bends[2]) / 2.0
    return np.array([*bends, upper, fore])


def radius(shape: Shape) -> float:
    """Of an upright shape, seen from above [m]."""
    x, y, _ = half_extents(shape)
    return hypot(x, y) if isinstance(shape, Box | Hull) else max(x, y)
