"""Plausibility of a reading: its numbers, its stamp, and the reading before."""

from enum import Enum
from math import isfinite

import numpy as np

from hw.state import RobotState
from robots import RobotDescription

_AHEAD = 0.005  # by which clocks of the parts may run ahead of the session's [s]
_BEYOND_RANGE = 0.5  # farthest that a joint can be outside its range [rad]
_JUMP = 0.05  # of a joint, by noise and interpolation [rad]
_OLDEST = 0.1  # age of a reading that is not stale [s]
_OVERSPEED = 2.0  # largest speed, in limits at full pace
_ROTATION_TOLERANCE = 1e-4


class Doubt(Enum):
    """Why a reading is implausible."""

    STALE = "the last reading is too old"
    FUTURE = "the reading is from the future"
    NOT_FINITE = "the reading is incomplete or not finite"
    IMPLAUSIBLE = "the reading is not plausible"


class Plausibility:
    """Judges the readings of one robot in turn; an old one is stale."""

    def __init__(self, description: RobotDescription) -> None:
        self._limits = description.limits
        self._max_speed = _OVERSPEED / description.pace  # full speed at reduced pace is believed
        self._before: RobotState | None = None

    def doubt(self, state: RobotState, now: float) -> Doubt | None:
        """Why a reading is implausible at session time `now` [s]; None if it is plausible."""
        if not self.is_fresh(state, now):
            return Doubt.STALE
        if state.stamp - now > _AHEAD:
            return Doubt.FUTURE
        if not _is_complete(state, self._limits.qd.shape):
            return Doubt.NOT_FINITE
        if not (self._is_within_reason(state) and self._follows(state)):
            return Doubt.IMPLAUSIBLE
        self._before = state
        return None

    def is_fresh(self, state: RobotState, now: float) -> bool:
        """Whether a reading is young enough at session time `now` [s]; NaN is not."""
        return now - state.stamp <= _OLDEST

    def _is_within_reason(self, state: RobotState) -> bool:
        limits = self._limits
        fastest = self._max_speed * np.maximum(limits.base_speed(state.base_twist), 0.1)
        return bool(
            (state.q >= limits.q_min - _BEYOND_RANGE).all()
            and (state.q <= limits.q_max + _BEYOND_RANGE).all()
            and (np.abs(state.qd) <= self._max_speed * limits.qd).all()
            and (np.abs(state.base_twist) <= fastest).all()
        )

    def _follows(self, state: RobotState) -> bool:
        before = self._before
        if before is None:
            return True
        elapsed = state.stamp - before.stamp
        if elapsed < 0.0:
            return False
        reach = _OVERSPEED * self._limits.qd * elapsed + _JUMP
        return bool((np.abs(state.q - before.q) <= reach).all())


def _is_complete(state: RobotState, arm: tuple[int, ...]) -> bool:
    """Whether all values have their shape and are finite, and wTb is a pose."""
    shapes = (np.shape(state.base_twist), np.shape(state.q), np.shape(state.qd))
    if shapes != ((3,), arm, arm):
        return False
    (a, b, c, x), (d, e, f, y), (g, h, i, z), _ = state.wTb.homogeneous.tolist()
    squares = a * a + b * b + c * c + d * d + e * e + f * f + g * g + h * h + i * i
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    # The product of three singular values is 1 and their squares add up to 3 only if all are 1.
    is_rotation = max(abs(squares - 3.0), abs(determinant - 1.0)) < _ROTATION_TOLERANCE
    numbers = (*state.base_twist, *state.q, *state.qd, x, y, z, state.gripper_width)
    return is_rotation and all(map(isfinite, numbers))
