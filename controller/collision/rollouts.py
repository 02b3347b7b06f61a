"""Rollouts: predicted motions of the base in the plane, and their cost near moving obstacles."""

from math import hypot
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from config.arrays import Array
from config.planar import Pose2D, rotate
from controller.model import RobotModel
from controller.surroundings import Obstacle
from robots import Box, Hull, Shape, half_extents

HORIZON = 2.7  # duration of a rollout [s]
MARGIN = 0.10  # desired distance of the base to moving obstacles [m]
STOPPING = 3  # number of rollouts of every velocity, the first ones, that end with a stop
_STEPS = np.array([0.1] * 10 + [0.2125] * 8)  # time steps of a rollout: finer at its beginning [s]
_KEPT = np.array([0.15, 0.5, HORIZON, 0.6, 1.3])
"""How long a velocity is kept [s]; then the base stops, or in the last ones follows its lead."""
_MARGIN_COST = 80.0  # cost of missing all of the margin, with the fourth power of the missing share
_PER_SPEED = 0.1  # increase of the margin per speed of the obstacle [s]
_STOPPED_MARGIN = 0.04  # desired distance to where the obstacle is, if the base stops [m]
_CONTACT_SPEED_COST = 80.0  # cost of a contact per approach speed [s/m] ...
_CONTACT_DEPTH_COST = 240.0  # ... and per `MARGIN` of its depth
_BRAKING = 0.8  # share of the acceleration limits assumed for the base
ARM_RADIUS = 0.08  # of the discs around the points that represent the arm [m]


class MovingScene(NamedTuple):
    """Moving obstacles and the robot that they may meet."""

    mTb: Pose2D
    arm: Array  # (K, 2) points that represent the arm, in the base frame [m]
    obstacles: list[Obstacle]


class Rollouts:
    """Predicts the motion of one robot's base."""

    def __init__(self, model: RobotModel) -> None:
        self._axes = model.description.base.axes
        length, width, _ = model.description.base.size
        self._half = np.array([length, width]) / 2.0
        self._acceleration = _BRAKING * model.acceleration_limits[: model.n_base]
        self._times = np.cumsum(_STEPS)
        self._middles = self._times - _STEPS / 2.0 - model.description.base.lag

    def predict(self, now: Array, velocities: Array, led: Array) -> Array:
        """Poses (V, T, K, 3) in the present base frame.

        Args:
            now: (n_base,) present velocity of the base.
            velocities: (V, n_base) kept for T different times.
            led: (n_base,) velocity after that; in the first `STOPPING` rollouts the base stops.
        """
        t, a = self._middles[:, None], self._acceleration
        kept = _KEPT[:, None, None]
        later = np.zeros((len(kept), 1, len(led)))
        later[STOPPING:] = led

        def changed(start: Array, end: Array, time: Array) -> Array:
            limit = a * np.maximum(time, 0.0)
            return np.asarray(start + np.clip(end - start, -limit, limit))

        there = changed(now, velocities[:, None, None], np.minimum(t, kept))
        twists = (changed(there, later, t - kept) @ self._axes.T) * _STEPS[:, None]
        headings = np.cumsum(twists[..., 2], axis=-1)
        middle = headings - twists[..., 2] / 2.0
        steps = rotate(middle, twists[..., 0], twists[..., 1])
        return np.stack([*(np.cumsum(step, axis=-1) for step in steps), headings], axis=-1)

    def cost(self, rollouts: Array, scene: MovingScene, margin: float) -> Array:
        """(V, T) cost of the distances to moving obstacles on rollouts (V, T, K, 3)."""
        mTb, arm = scene.mTb, scene.arm
        cost = np.zeros(rollouts.shape[:2])
        c, s = np.cos(mTb.heading), np.sin(mTb.heading)
        turn = np.array([[c, -s], [s, c]])
        for one in scene.obstacles:
            centre = (one.geom.pose.translation[:2] - [mTb.x, mTb.y]) @ turn
            velocity, own = one.velocity[:2] @ turn, radius(one.geom.shape)
            wide = margin + _PER_SPEED * hypot(*velocity.tolist())
            path = centre + self._times[:, None] * velocity
            d = self._distance(rollouts, path, arm) - own
            # A walking person may stop, so the base must be able to stop at once, too.
            stops = self._distance(rollouts[:, :1], centre[None], arm) - own
            here = float(self._distance(np.zeros(3), centre, arm)) - own
            close = np.maximum(min(_STOPPED_MARGIN, here) - stops.min(axis=-1), 0.0) / MARGIN
            short = np.clip(wide - d.min(axis=-1), 0.0, wide) / wide
            cost += _MARGIN_COST * (short**4 + close**2)
            cost += self._contact_cost(rollouts, d, path, arm, own)
        return cost

    def _contact_cost(
        self, rollouts: Array, d: Array, path: Array, arm: Array, own: float
    ) -> Array:
        """(V, T) cost of contact, by the approach speed at its beginning and by its depth.

        `d` (V, T, K) are distances to an obstacle of radius `own` on its path (K, 2).
        """
        inside = d < 0.0
        if not inside.any():
            return np.zeros(d.shape[:-1])
        first = np.maximum(inside.argmax(axis=-1), 1)
        before = np.take_along_axis(rollouts, first[..., None, None] - 1, 2)[:, :, 0]
        at_first = np.take_along_axis(d, first[..., None], 2)[..., 0]
        closing = self._distance(before, path[first], arm) - own - at_first
        closing = np.maximum(closing, 0.0) / _STEPS[first]
        cost = _CONTACT_SPEED_COST * closing - _CONTACT_DEPTH_COST * d.min(axis=-1) / MARGIN
        return np.where(inside.any(axis=-1), cost, 0.0)

    def _distance(self, bases: Array, points: Array, arm: Array) -> Array:
        """(...) distances of base poses (..., 3), with the arm, to points (..., 2) [m]."""
        dx, dy = points[..., 0] - bases[..., 0], points[..., 1] - bases[..., 1]
        x, y = rotate(-bases[..., 2], dx, dy)
        beyond_x, beyond_y = np.abs(x) - self._half[0], np.abs(y) - self._half[1]
        d = np.hypot(np.maximum(beyond_x, 0.0), np.maximum(beyond_y, 0.0))
        d += np.minimum(np.maximum(beyond_x, beyond_y), 0.0)
        for ax, ay in arm.tolist():
            d = np.minimum(d, np.hypot(x - ax, y - ay) - ARM_RADIUS)
        return np.asarray(d)


def arm_points(model: RobotModel, q: Array) -> Array:
    """(K, 2) points that represent the arm from above, in the base frame, at q (j,) [m]."""
    poses = model.link_poses(SE3.Identity(), q)
    j = model.n_arm
    bends = [poses[number].translation[:2] for number in (0, j // 2 + 1, j - 1, j, j + 1)]
    bends.append(model.bTe(q).translation[:2])
    upper, fore = (bends[0] + bends[1]) / 2.0, (bends[1] + bends[2]) / 2.0
    return np.array([*bends, upper, fore])


def radius(shape: Shape) -> float:
    """Radius of the circle around an upright shape, seen from above [m]."""
    x, y, _ = half_extents(shape)
    return hypot(x, y) if isinstance(shape, Box | Hull) else max(x, y)
