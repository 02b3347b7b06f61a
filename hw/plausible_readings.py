"""Plausibility of a reading: its numbers, its stamp, and the reading before."""

import numpy as np
from pinocchio import SE3

from config.arrays import Mask
from controller import is_rotation
from hw.checked_values import RefusedError, covariance, number, numbers
from hw.state import Array, LocalisedPose, RobotState
from robots import RobotDescription

OLDEST = 0.1  # age of a reading that is not stale [s]
_AHEAD = 0.005  # by which clocks of the parts may run ahead of the session's [s]
_BEYOND_RANGE = 0.5  # farthest that a joint can be outside its range [rad]
_JUMP = 0.05  # of a joint, by noise and interpolation [rad]
_OVERSPEED = 2.0  # largest speed, in limits at full pace


class Plausibility:
    """Judges the readings of one robot in turn; an old one is stale.

    A joint that has jumped is not believed however long it stays there, unless a fault was
    reported meanwhile: what clears that has seen to the arm.
    """

    def __init__(self, description: RobotDescription) -> None:
        self._limits = description.limits
        self._max_speed = _OVERSPEED / description.pace  # full speed at reduced pace is believed
        self._joints = [f"joint {k}" for k in range(1, len(self._limits.qd) + 1)]
        self._before: RobotState | None = None
        self._jumped: float | None = None  # stamp of the first reading after a jump [s]
        self._localised: LocalisedPose | None = None  # the newest that is plausible

    def doubt(self, state: RobotState, now: float) -> str:
        """Why a reading is implausible at session time `now` [s]; empty if it is plausible."""
        if not self.is_fresh(state, now):
            return f"the last reading{_of_part(state)} is {now - state.stamp:.2f} s old"
        if state.stamp - now > _AHEAD:
            return f"the last reading is {state.stamp - now:.2f} s from the future"
        for part, judge in (("base", self._base), ("arm", self._arm), ("gripper", self._gripper)):
            try:
                judge(state)
            except RefusedError as wrong:
                return f"the {part} tells {wrong}"
        self._before, self._jumped = state, None
        return ""

    def is_fresh(self, state: RobotState, now: float) -> bool:
        """Whether a reading is young enough at session time `now` [s]; NaN is not."""
        return now - state.stamp <= OLDEST

    def _base(self, state: RobotState) -> None:
        twist = numbers(state.base_twist, ("vx", "vy", "w"), "twist")
        fastest = self._max_speed * np.maximum(self._limits.base_speed(twist), 0.1)
        if (np.abs(twist) > fastest).any():
            raise RefusedError("twist", np.round(twist, 2), "faster than it can be")
        _check_pose(state.oTb, "oTb")
        if state.battery is not None:
            number(state.battery, "battery", 0.0, 1.0)
        if (here := state.localised) is not None and here is not self._localised:
            _check_pose(here.mTb, "mTb")
            covariance(here.covariance, "covariance")
            number(here.stamp, "stamp of mTb")
            self._localised = here

    def _arm(self, state: RobotState) -> None:
        limits, q = self._limits, numbers(state.q, self._joints, "q")
        numbers(state.qd, self._joints, "qd")
        outside = np.maximum(q - limits.q_max, limits.q_min - q)
        self._refuse("q", q, outside > _BEYOND_RANGE, "outside of its range")
        too_fast = np.abs(state.qd) > self._max_speed * limits.qd
        self._refuse("qd", state.qd, too_fast, "faster than it can be")
        before = self._before
        if before is None:
            return
        elapsed = state.stamp - before.stamp
        if elapsed < 0.0:
            raise RefusedError("stamp", f"{state.stamp:.2f} s", "before that of the last reading")
        if before.faults or state.faults:
            return
        if self._jumped is not None:
            elapsed = min(elapsed, self._jumped - before.stamp)
        reach = _OVERSPEED * limits.qd * elapsed + _JUMP
        jumps = np.abs(q - before.q) > reach
        if jumps.any():
            self._jumped = state.stamp if self._jumped is None else self._jumped
        self._refuse("q", q, jumps, "it has jumped: see whether its encoder is right")

    def _gripper(self, state: RobotState) -> None:
        number(state.gripper_width, "width")

    def _refuse(self, field: str, values: Array, wrong: Mask, why: str) -> None:
        """Refuse the first joint that is wrong."""
        if wrong.any():
            k = int(wrong.argmax())
            raise RefusedError(f"{field}[{self._joints[k]}]", f"{values[k]:.2f}", why)


def _check_pose(pose: SE3, field: str) -> None:
    """Refuse what is no pose."""
    if not is_rotation(pose):
        raise RefusedError(f"rotation of {field}", pose.rotation.tolist(), "no rotation")
    numbers(pose.translation, ("x", "y", "z"), f"position of {field}")


def _of_part(state: RobotState) -> str:
    """The part whose reading is the oldest, where that is known."""
    if state.stamps is None:
        return ""
    return f" of the {'arm' if state.stamps.arm < state.stamps.base else 'base'}"
