"""How fast a goal moves, from where it was in one control period after another.

Position and orientation each have a fading-memory filter of the second order (the critically damped
alpha-beta filter; Morrison, "Introduction to Sequential Smoothing and Prediction", 1969). A goal
that jumps is another goal and not a fast one, and a goal that only trembles, as one that is seen
anew in every frame, stands still.
"""

from __future__ import annotations

from dataclasses import replace
from math import exp, sqrt

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller.command import Array, PoseGoal

_MEMORY = 0.1
"""Time constant of the filters: twice this is what the velocity lags behind [s]."""
_JUMP, _TURN = 0.008, 0.03
"""A change in one period that differs from the one before by more than this is a jump [m, rad]."""
_STILL, _STILL_TURN = 0.02, 0.06
"""A velocity below this is none, and one above twice this counts fully [m/s, rad/s]."""
_REST = 1e-9
"""What is smaller than this does not change any longer [m, rad and per second]."""


class GoalVelocity:
    """Keeps the velocity of the goal from period to period.

    Args:
        period: control period [s].
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self.reset()

    def reset(self) -> None:
        """Forget the goal: the next one stands still."""
        self._last: SE3 | None = None
        self._settled = False
        """Whether the goal has stood still for so long that the filters have nothing to forget."""
        self._linear = _Filter(self._period, _JUMP, _STILL)
        self._angular = _Filter(self._period, _TURN, _STILL_TURN)

    def __call__(self, goal: PoseGoal) -> PoseGoal:
        """The goal with the velocity that it seems to have, unless it is given or none."""
        last = self._last
        stands = last is not None and goal.wTe == last
        if stands and (self._settled or goal.twist is not None):
            return goal
        self._last = goal.wTe.copy()
        if last is None or goal.twist is not None:
            return goal
        linear = self._linear(goal.wTe.translation - last.translation)
        angular = self._angular(pin.log3(goal.wTe.rotation @ last.rotation.T))
        self._settled = stands and self._linear.at_rest and self._angular.at_rest
        if linear is None and angular is None:
            return goal
        nothing = np.zeros(3)
        twist = [nothing if part is None else part for part in (linear, angular)]
        return replace(goal, twist=np.concatenate(twist))


class _Filter:
    """The rate of three numbers from their changes.

    Args:
        period: time between two changes [s].
        jump: a change that differs from the one before by more than this is a jump.
        still: a rate below this is none, one above twice this counts fully [1/s].
    """

    def __init__(self, period: float, jump: float, still: float) -> None:
        fading = exp(-period / _MEMORY)
        self._position_gain = 1.0 - fading * fading
        self._rate_gain = (1.0 - fading) ** 2 / period
        self._period, self._jump, self._still = period, jump, still
        self._last_change = np.zeros(3)
        self._forget()

    def _forget(self) -> None:
        self._behind = np.zeros(3)  # what the filtered position lacks
        self._rate = np.zeros(3)
        self.at_rest = True
        """Whether nothing changes any longer while the goal stands still."""

    def __call__(self, change: Array) -> Array | None:
        """The rate (3,) after another change (3,); None if there is none."""
        size, unlike = _length(change), _length(change - self._last_change)
        self._last_change = change
        if unlike > self._jump:
            self._forget()
        elif size > _REST or not self.at_rest:
            innovation = self._behind + change - self._rate * self._period
            self._rate = self._rate + self._rate_gain * innovation
            self._behind = (1.0 - self._position_gain) * innovation
            self.at_rest = max(_length(self._rate), _length(self._behind)) < _REST
        share = _length(self._rate) / self._still - 1.0
        return self._rate * min(1.0, share) if share > 0.0 else None


def _length(vector: Array) -> float:
    x, y, z = vector.tolist()
    return sqrt(x * x + y * y + z * z)
