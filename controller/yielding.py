"""Giving way to what moves: rows that look ahead to when base and obstacle are nearest.

The distance rows know how near an obstacle is and how fast it comes. A base that drives across its
way is told too late by them, and one that cannot drive sideways in the wrong direction. So the
place p of the obstacle seen from the base is led on with their velocities to the time t of the
closest approach, at most `HORIZON` ahead, as velocity obstacles do (Fiorini and Shiller, IJRR
1998). Where the circles around both would overlap then, with n the direction from base to obstacle
at that time, R the sum of the radii and v_o the obstacle's velocity, the base is asked for

    nᵀ (p + (v_o - v) t) >= R,    v = J q̇ the velocity of its centre in the world, on average.

That is to go slower, faster or aside: as the obstacle passes ahead or behind.
"""

from __future__ import annotations

from math import cos, hypot, sin
from typing import NamedTuple

import numpy as np

from controller.base_drive import Pose2D
from controller.collision_model import PairKind
from controller.command import Array
from controller.model import RobotModel
from controller.qp import Rows
from controller.surroundings import Obstacle
from robots import half_extents

HORIZON = 3.0
"""How far the courses of base and obstacle are led on [s]."""
_SOONEST = 0.3
"""A closest approach that is nearer in time counts as this far ahead [s]."""
_MARGIN = 0.10
"""Between the circles [m]."""
_NEARER = 0.95
"""Share of the distance that is left to an obstacle inside the circles."""
_STILL = 0.05
"""What moves more slowly than this stands [m/s]."""


class Yielding(NamedTuple):
    """To whom the base gives way."""

    rows: Rows | None
    """None if to nobody."""
    obstacle: str = ""
    """Who it is, for people."""


def give_way(
    model: RobotModel,
    wTb: Pose2D,
    velocities: Array,
    obstacles: tuple[Obstacle, ...],
    bounds: tuple[Array, Array],
) -> Yielding:
    """Rows for the base, one for each obstacle that it would meet.

    Args:
        model: the robot.
        wTb: base pose.
        velocities: (n,) of all degrees of freedom as they are now.
        obstacles: what moves by itself.
        bounds: lower and upper bounds (n,) of the velocities.
    """
    found: list[tuple[Array, float, str]] = []
    for one in obstacles:
        row = _row(model, wTb, velocities, one)
        if row is not None and np.minimum(row[0] * bounds[0], row[0] * bounds[1]).sum() < row[1]:
            found.append((*row, one.geom.name))
    if not found:
        return Yielding(None)
    A, least, names = zip(*found, strict=True)
    group = np.full(len(found), int(PairKind.AHEAD))
    return Yielding(Rows(np.array(A), np.array(least), group), names[0])


def _row(
    model: RobotModel, wTb: Pose2D, velocities: Array, obstacle: Obstacle
) -> tuple[Array, float] | None:
    """The row (n,) and the least value of one obstacle; None if it is not met."""
    ox, oy = obstacle.velocity[:2].tolist()
    if hypot(ox, oy) < _STILL:
        return None
    axes, n_base = model.description.base.axes, model.n_base
    c, s = cos(wTb.heading), sin(wTb.heading)
    J = np.array([[c, -s], [s, c]]) @ axes[:2]  # (2, n_base) of the centre, in the world
    vx, vy = (J @ velocities[:n_base]).tolist()
    x, y, _ = obstacle.geom.pose.translation.tolist()
    px, py, rx, ry = x - wTb.x, y - wTb.y, ox - vx, oy - vy
    speed = hypot(rx, ry)
    t = -(px * rx + py * ry) / max(speed * speed, 1e-9)
    if not 0.0 < t < HORIZON:
        return None
    t = max(t, _SOONEST)
    half_x, half_y, _ = half_extents(obstacle.geom.shape)
    length, width, _ = model.description.base.size
    R = max(half_x, half_y) + hypot(length, width) / 2.0 + _MARGIN
    # What is inside the circle already shall come no nearer than it is.
    R = min(R, _NEARER * hypot(px, py))
    across = px * -ry / speed + py * rx / speed  # of p at that time, along (-ry, rx) / speed
    if abs(across) >= R:
        return None
    n = np.array([-ry, rx]) / speed
    sides = [n, -n] if across >= 0.0 else [-n, n]
    rows = [_half_plane(model, J, velocities, t, side, (px, py), (ox, oy), R) for side in sides]
    return next((row for row in rows if _is_possible(model, row)), rows[0])


def _half_plane(
    model: RobotModel,
    J: Array,
    velocities: Array,
    t: float,
    n: Array,
    p: tuple[float, float],
    v_o: tuple[float, float],
    R: float,
) -> tuple[Array, float]:
    """nᵀ v <= (nᵀ p - R) / t + nᵀ v_o, as a row."""
    row = np.zeros(model.n)
    row[: model.n_base] = -(n @ J)
    # A base that turns while it drives has gone aside by v ω t² / 2.
    vx, vy = J @ velocities[: model.n_base]
    row[: model.n_base] -= 0.5 * t * (n[1] * vx - n[0] * vy) * model.base_turn
    return row, -(float(n @ np.array(p)) - R) / t - float(n @ np.array(v_o))


def _is_possible(model: RobotModel, row: tuple[Array, float]) -> bool:
    """Whether the base is fast enough for that in the end."""
    lower, upper = model.velocity_limits
    return bool(np.maximum(row[0] * lower, row[0] * upper).sum() >= row[1])
