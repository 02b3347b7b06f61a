"""Giving way to what moves: the base looks ahead at where its velocities would lead it.

The distance rows know how near an obstacle is and how fast it comes. A base that drives across its
way is told too late by them, and one that cannot drive sideways is told the wrong thing. So the
velocity that the rows leave is led on for `HORIZON`, as in the dynamic window approach (Fox,
Burgard and Thrun, RAM 1997), and what moves is led on with its own velocity. Seen from above, base
and arm must keep off it if the base keeps its velocity for a moment and then stops. As long as that
holds nothing is changed: who stops beside the way of somebody does so no earlier than it must.

Else the base takes another of the velocities that its limits allow, on whose way nothing stands. It
is kept for a while, and then the base stops or goes on where it is led. The one is taken after
which the base is nearest to where it would be if nothing moved, what comes nearer than `MARGIN`
being paid for. That is to go slower, faster, back or aside. The QP is asked for it by rows.
"""

from __future__ import annotations

from math import hypot, inf

import numpy as np

from controller.collision.collision_model import PairKind
from controller.collision.rollouts import (
    HORIZON,
    MARGIN,
    STOPPING,
    MovingScene,
    Rollouts,
    radius,
    seen_from_above,
)
from controller.command import Array
from controller.floor import FloorMap, Pose2D
from controller.model import RobotModel
from controller.qp_solver import Rows
from controller.surroundings import Obstacle

_ENOUGH = 0.06
"""What the base puts up with before it gives way [m]."""
_AGAIN = 1
"""Who has given way goes on where it might do so longer: after the shortest courses left out."""
_CHANGE = 0.3
"""What it costs to give way otherwise than in the last period."""
_TURN = 0.3
"""What a radian of heading counts like at the end of a course [m]."""
_SHARES = (1.0, 0.75, 0.5, 0.25, 0.0)
"""Of the velocity that the base is led with."""
_STILL = 0.05
"""What moves more slowly than this stands [m/s]."""
_REACH = 1.3
"""Nothing of the robot is farther from the centre of its base [m]."""
_ROOM = 0.02
"""From what stands on the way of the base, unless it is nearer already [m]."""
_NOISE = 0.005
"""Of the map [m]."""
_AT_ONCE = 8
"""Rollouts whose ways are checked together."""
_TRIED = 96
"""Rollouts whose ways are checked, at most."""
_TOLERANCE = 1e-3
"""The QP keeps the velocity to this [m/s, rad/s]."""
_BINDS = 1e-4
"""A row binds that is kept by no more than this [m/s]."""


class MovingObstacleAvoidance:
    """Decides how the base of one robot gives way, from period to period.

    Args:
        model: the robot.
    """

    def __init__(self, model: RobotModel) -> None:
        self._model = model
        n_base = model.n_base
        self._lower, self._upper = model.velocity_limits[:, :n_base]
        self._velocities = _grid(model)
        self._courses = Rollouts(model)
        self._taken: Array | None = None
        """(n_base,) velocity that the base took in the last period to give way."""

    def rows(
        self,
        wTb: Pose2D,
        q: Array,
        velocities: Array,
        wanted: Array,
        led: Array | None,
        obstacles: tuple[Obstacle, ...],
        floor: FloorMap | None,
        bounds: tuple[Array, Array],
    ) -> Rows | None:
        """Rows that keep the base at a velocity that gives way; None where there is no need.

        Args:
            wTb: base pose.
            q: (7,) joint positions [rad].
            velocities: (n,) of all degrees of freedom as they are now.
            wanted: (n,) what they would be in this period.
            led: (n_base,) where the base is led, and shall be as fast as it can be; None if it
                is not.
            obstacles: what moves by itself.
            floor: what stands around, if that is known.
            bounds: lower and upper bounds (n,) of the velocities.
        """
        n_base, n = self._model.n_base, self._model.n
        before, self._taken = self._taken, None
        near = [one for one in obstacles if self._matters(one, wTb)]
        if not near:
            return None
        sight = MovingScene(wTb, seen_from_above(self._model, q), near)
        now, wanted = velocities[:n_base], wanted[:n_base]
        skipped = 0 if before is None else _AGAIN
        led = wanted if led is None else np.clip(led, self._lower, self._upper)
        courses = self._courses.of(now, np.array([wanted, led]), led)
        there = courses[1, STOPPING - 1, -1]
        missing = self._courses.missing(courses, sight, _ENOUGH)
        if min(missing[0, skipped:STOPPING].min(), missing[1, STOPPING - 1]) <= 0.0:
            return None
        others = [*self._velocities, *(share * led for share in _SHARES), wanted]
        if before is not None:
            others.append(before)
        tried = np.array(others)
        courses = self._courses.of(now, tried, led)
        cost = self._courses.missing(courses, sight, MARGIN)
        cost += np.sqrt(((courses[:, :, -1] - there) ** 2) @ [1.0, 1.0, _TURN**2])
        if before is not None:
            cost += _CHANGE * (((tried - before) / self._upper) ** 2).sum(axis=1)[:, None]
        found = self._cheapest(cost.ravel(), courses.reshape(-1, *courses.shape[2:]), wTb, floor)
        self._taken = taken = tried[found // courses.shape[1]]
        command = np.clip(taken, bounds[0][:n_base], bounds[1][:n_base])
        A = np.zeros((2 * n_base, n))
        A[:n_base, :n_base], A[n_base:, :n_base] = np.eye(n_base), -np.eye(n_base)
        least = np.concatenate([command, -command]) - _TOLERANCE
        return Rows(A, least, np.full(2 * n_base, int(PairKind.AHEAD)))

    def _matters(self, obstacle: Obstacle, wTb: Pose2D) -> bool:
        """Whether it moves, and could meet the robot before long."""
        speed = hypot(*obstacle.velocity[:2].tolist())
        x, y, _ = obstacle.geom.pose.translation.tolist()
        reach = _REACH + radius(obstacle.geom.shape) + MARGIN
        fastest = float(self._model.limits.base_twist[0])
        return speed > _STILL and hypot(x - wTb.x, y - wTb.y) < reach + (speed + fastest) * HORIZON

    def _cheapest(self, cost: Array, courses: Array, wTb: Pose2D, floor: FloorMap | None) -> int:
        """Number of the cheapest course on which nothing stands; else of that with most room."""
        order = np.argsort(cost, kind="stable")
        if floor is None or floor.free:
            return int(order[0])
        (here,) = floor.stands_free(np.array([wTb])).tolist()
        best, most = int(order[0]), -inf
        c, s = np.cos(wTb.heading), np.sin(wTb.heading)
        for first in range(0, min(_TRIED, len(order)), _AT_ONCE):
            some = order[first : first + _AT_ONCE]
            x, y, heading = np.moveaxis(courses[some][:, 1::2], -1, 0)
            poses = [wTb.x + c * x - s * y, wTb.y + s * x + c * y, wTb.heading + heading]
            room = floor.stands_free(np.stack(poses, axis=-1)).reshape(x.shape).min(axis=1)
            (free,) = np.nonzero(room >= min(_ROOM, here - _NOISE))
            if len(free):
                return int(some[free[0]])
            if room.max() > most:
                best, most = int(some[room.argmax()]), float(room.max())
        return best


def _grid(model: RobotModel) -> Array:
    """(V, n_base) velocities all over what the limits allow."""
    lower, upper = model.velocity_limits[:, : model.n_base]
    turning = model.base_turn > 0.5
    counts = np.where(turning, 5, 6) if model.n_base == 2 else np.where(turning, 3, 5)
    axes = [np.linspace(a, b, n) for a, b, n in zip(lower, upper, counts.tolist(), strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, model.n_base)


def waits_for(
    here: Pose2D, moving: tuple[Obstacle, ...], rows: Rows | None, velocities: Array | None
) -> str:
    """Who is nearest of what moves, where velocities (n,) are bound by a row because of it."""
    if rows is None or velocities is None:
        return ""
    because = (rows.group >= PairKind.BASE_MOVING) & (rows.group <= PairKind.AHEAD)
    if not (because & (rows.A @ velocities < rows.least + _BINDS)).any():
        return ""

    def distance(one: Obstacle) -> float:
        x, y, _ = one.geom.pose.translation.tolist()
        return hypot(x - here.x, y - here.y)

    return min(moving, key=distance).geom.name
