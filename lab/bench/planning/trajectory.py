"""Time-optimal trajectories of the arm along paths, within joint speeds and accelerations."""

from typing import NamedTuple

import numpy as np

from config.arrays import Array
from controller import RobotModel

_GRID = 240  # number of intervals of a path
_LEAST = 1e-9


class Trajectory(NamedTuple):
    """Joint positions and velocities in every period."""

    q: Array  # (K, j) positions [rad]
    qd: Array  # (K, j) velocities; zero in the end [rad/s]
    period: float  # [s]

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
    """The trajectory from rest to rest along a cubic spline through postures (M, j), M at least 2.

    The speed profile is the largest that keeps the joint accelerations: one pass forwards, one
    backwards. `speed` is the largest speed of the end effector [m/s]; the shares are those of the
    joint speed and acceleration limits.
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
    # In a bend one half of the acceleration is for the bend, the other for changes of speed.
    fastest = np.minimum(fastest, np.sqrt(0.5 * qdd / np.maximum(bend, _LEAST)).min(axis=1))
    v = _passed(s, fastest, slope, bend, qdd)
    v = _passed(s[-1] - s[::-1], v[::-1], slope[::-1], bend[::-1], qdd)[::-1]
    ends = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / np.maximum(v[1:] + v[:-1], 1e-6))])
    times = np.arange(1, int(np.ceil(ends[-1] / period)) + 1) * period
    at = np.interp(times, ends, s)
    speeds = np.where(times < ends[-1], np.interp(times, ends, v), 0.0)
    return Trajectory(spline(at), spline(at, 1) * speeds[:, None], period)


def _passed(s: Array, fastest: Array, slope: Array, bend: Array, qdd: Array) -> Array:
    """Speeds (G,) along s that are reached from rest, below `fastest`."""
    v = np.zeros(len(s))
    for i in range(len(s) - 1):
        room = np.maximum(qdd - bend[i] * v[i] * v[i], 0.0)
        acceleration = float((room / np.maximum(slope[i], _LEAST)).min())
        v[i + 1] = min(
            fastest[i + 1], np.sqrt(v[i] * v[i] + 2.0 * acceleration * (s[i + 1] - s[i]))
        )
    return v
