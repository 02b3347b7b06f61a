"""Whether the robot does what it is commanded: commanded motion against measured motion.

A frozen reading with fresh stamps, a base that ignores its commands and an arm that moves by itself
have plausible readings, one by one. Over the last moments they do not fit what was commanded.
"""

from __future__ import annotations

from collections import deque
from math import cos, hypot, pi, remainder, sin
from typing import NamedTuple

import numpy as np

from controller import Command
from hw.state import Array, RobotState
from robots import RobotDescription

_WINDOW = 1.0
"""How far back motion is compared [s]."""
_BASE_PATH = 0.25
"""A base that was commanded this far has moved [m] ..."""
_ARM_PATH = 0.15
"""... and so has a joint that was commanded this far [rad] ..."""
_LEAST_SHARE = 0.2
"""... by at least this share of it."""
_BASE_SURPLUS = 0.3
"""The base does not move farther than this without a command [m] ..."""
_ARM_SURPLUS = 0.15
"""... nor a joint farther than this [rad], its lag apart."""
_METRES_PER_RADIAN = 0.3
"""What a turn of the base counts [m/rad]."""
_JUMP = 0.03
"""A base that moves this much farther between two readings than it can was relocalised [m]."""


class _Moment(NamedTuple):
    """Sums since the window was begun."""

    stamp: float
    base_path: float
    """Commanded [m]."""
    arm_path: float
    """Commanded, of the joint that was commanded farthest in each period [rad]."""
    base_commanded: tuple[float, float, float]
    """Dead reckoning of the commanded twists: x, y, heading."""
    base_measured: tuple[float, float, float]
    arm_commanded: Array
    """(7,) integral of the commanded joint velocities [rad]."""
    q: Array


class Following:
    """Compares the commands of one robot with what it measures.

    Args:
        description: of the robot.
    """

    def __init__(self, description: RobotDescription) -> None:
        limits = description.limits
        self._base_surplus = _BASE_SURPLUS + 2.0 * description.base.lag * limits.base_twist.max()
        self._arm_surplus = _ARM_SURPLUS + 2.0 * description.arm.lag * limits.qd
        self._fastest = 2.0 * (limits.base_twist[:2].max() + 0.3 * limits.base_twist[2])
        self._moments: deque[_Moment] = deque()

    def forget(self) -> None:
        """Compare from the next reading on: for example after a fault, or a gap in the commands."""
        self._moments.clear()

    def mismatch(self, state: RobotState, applied: Command) -> str:
        """What does not fit, for people; empty if all does.

        Args:
            state: a plausible reading.
            applied: the command that was applied from the reading before to this one.
        """
        heading = float(np.arctan2(state.wTb.rotation[1, 0], state.wTb.rotation[0, 0]))
        measured = (float(state.wTb.translation[0]), float(state.wTb.translation[1]), heading)
        if not self._moments:
            start = (0.0, 0.0, 0.0)
            self._moments.append(
                _Moment(state.stamp, 0.0, 0.0, start, measured, np.zeros(7), state.q)
            )
            return ""
        before = self._moments[-1]
        dt = state.stamp - before.stamp
        if dt <= 0.0:
            return ""
        vx, vy, w = applied.base_twist.tolist()
        if _length(_between(before.base_measured, measured)) > self._fastest * dt + _JUMP:
            self._rebase(measured)
            before = self._moments[-1]
        newest = _Moment(
            stamp=state.stamp,
            base_path=before.base_path + (hypot(vx, vy) + _METRES_PER_RADIAN * abs(w)) * dt,
            arm_path=before.arm_path + float(np.abs(applied.qd).max()) * dt,
            base_commanded=_moved(before.base_commanded, vx * dt, vy * dt, w * dt),
            base_measured=measured,
            arm_commanded=before.arm_commanded + applied.qd * dt,
            q=state.q,
        )
        self._moments.append(newest)
        while self._moments[1].stamp < newest.stamp - _WINDOW:
            self._moments.popleft()
        return self._base_mismatch(newest) or self._arm_mismatch(newest)

    def _base_mismatch(self, newest: _Moment) -> str:
        then = self._moments[0]
        for moment in self._moments:  # the shortest way that is long enough tells soonest
            if newest.base_path - moment.base_path < _BASE_PATH:
                break
            then = moment
        commanded = _between(then.base_commanded, newest.base_commanded)
        moved = _length(_between(then.base_measured, newest.base_measured))
        asked = _length(commanded)
        if asked >= 0.8 * _BASE_PATH and moved < _LEAST_SHARE * asked:
            return "the base does not do what it is commanded"
        first = self._moments[0]
        commanded = _between(first.base_commanded, newest.base_commanded)
        surplus = _between(commanded, _between(first.base_measured, newest.base_measured))
        if _length(surplus) > self._base_surplus:
            return "the base moves as it was not commanded"
        return ""

    def _arm_mismatch(self, newest: _Moment) -> str:
        then = self._moments[0]
        for moment in self._moments:
            if newest.arm_path - moment.arm_path < _ARM_PATH:
                break
            then = moment
        asked = newest.arm_commanded - then.arm_commanded
        joint = int(np.abs(asked).argmax())
        moved = abs(float(newest.q[joint] - then.q[joint]))
        if abs(asked[joint]) >= 0.8 * _ARM_PATH and moved < _LEAST_SHARE * abs(asked[joint]):
            return f"joint {joint + 1} does not do what it is commanded"
        first = self._moments[0]
        surplus = (newest.q - first.q) - (newest.arm_commanded - first.arm_commanded)
        over = np.abs(surplus) - self._arm_surplus
        if (over > 0.0).any():
            return f"joint {int(over.argmax()) + 1} moves as it was not commanded"
        return ""

    def _rebase(self, measured: tuple[float, float, float]) -> None:
        """Go on from a new place of the base in the world: it was relocalised, not moved."""
        last = self._moments[-1]
        self._moments.clear()
        self._moments.append(last._replace(base_measured=measured))


def _moved(
    pose: tuple[float, float, float], x: float, y: float, turn: float
) -> tuple[float, float, float]:
    heading = pose[2] + turn / 2.0
    c, s = cos(heading), sin(heading)
    return (pose[0] + c * x - s * y, pose[1] + s * x + c * y, pose[2] + turn)


def _between(
    a: tuple[float, float, float], b: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Pose b seen from pose a."""
    x, y = b[0] - a[0], b[1] - a[1]
    c, s = cos(a[2]), sin(a[2])
    return (c * x + s * y, c * y - s * x, remainder(b[2] - a[2], 2.0 * pi))


def _length(pose: tuple[float, float, float]) -> float:
    return hypot(pose[0], pose[1]) + _METRES_PER_RADIAN * abs(pose[2])
