"""A path of the arm in time: as fast as speeds and accelerations of the joints allow."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from controller.command import Array
from controller.model import RobotModel

_GRID = 240
"""Intervals that a path is divided into."""
_LEAST = 1e-9


class Trajectory(NamedTuple):
    """Where the joints are in every period."""

    q: Array
    """(K, 7) positions [rad]."""
    qd: Array
    """(K, 7) velocities; zero in the end [rad/s]."""
    period: float
    """[s]."""

    @property
    def duration(self) -> float:
        """[s]."""
        return len(self.q) * self.period


def timed(
    model: RobotModel,
    path: Array,
    period: float,
    *,
    speed: float,
    speed_share: float,
    acceleration_share: float,
) -> Trajectory:
    """The trajectory along a path, from rest to rest.

    The path is a cubic spline through its postures. Along it the speed is the largest from which
    every joint can still keep its acceleration: one pass forwards, one backwards.

    Args:
        model: the robot.
        path: (M, 7) postures, M at least 2 [rad].
        period: of control [s].
        speed: largest speed of the end effector [m/s].
        speed_share: share of the joint speeds that is used.
        acceleration_share: the same of the accelerations.
    """
    from scipy.interpolate import CubicSpline

    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    path = path[np.concatenate([[True], steps > 1e-6])]
    if len(path) < 2:
        return Trajectory(path[-1:], np.zeros((1, path.shape[1])), period)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    spline = CubicSpline(along, path)
    s = np.linspace(0.0, along[-1], _GRID + 1)
    q, slope, bend = spline(s), np.abs(spline(s, 1)), np.abs(spline(s, 2))
    qd = speed_share * model.limits.qd
    qdd = acceleration_share * model.limits.qdd
    tool = np.array([model.bTe(one).translation for one in q])
    tool_slope = np.linalg.norm(np.gradient(tool, s, axis=0), axis=1)
    fastest = np.minimum((qd / np.maximum(slope, _LEAST)).min(axis=1), speed / (tool_slope + 1e-6))
    # In a bend half of the acceleration is left to keep to it, and half to change the speed.
    fastest = np.minimum(fastest, np.sqrt(0.5 * qdd / np.maximum(bend, _LEAST)).min(axis=1))
    v = _passed(s, fastest, slope, bend, qdd)
    v = _passed(s[-1] - s[::-1], v[::-1], slope[::-1], bend[::-1], qdd)[::-1]
    ends = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / np.maximum(v[1:] + v[:-1], 1e-6))])
    times = np.arange(1, int(np.ceil(ends[-1] / period)) + 1) * period
    at = np.interp(times, ends, s)
    speeds = np.where(times < ends[-1], np.interp(times, ends, v), 0.0)
    return Trajectory(spline(at), spline(at, 1) * speeds[:, None], period)


def _passed(s: Array, fastest: Array, slope: Array, bend: Array, qdd: Array) -> Array:
    """Speeds (G,) along s that are reached from rest and keep below `fastest`."""
    v = np.zeros(len(s))
    for i in range(len(s) - 1):
        room = np.maximum(qdd - bend[i] * v[i] * v[i], 0.0)
        acceleration = float((room / np.maximum(slope[i], _LEAST)).min())
        v[i + 1] = min(
            fastest[i + 1], np.sqrt(v[i] * v[i] + 2.0 * acceleration * (s[i + 1] - s[i]))
        )
    return v
