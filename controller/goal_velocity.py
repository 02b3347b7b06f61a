"""Estimates the velocity of a moving goal from successive goals.

Position and orientation each have a fading-memory filter of the second order (the critically damped
alpha-beta filter; Morrison, "Introduction to Sequential Smoothing and Prediction", 1969). A goal
that jumps is a new goal, and one that jitters, as detected anew in every frame, is at rest.
"""

from __future__ import annotations

from dataclasses import replace
from math import exp, sqrt

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller.command import Array, PoseGoal

_MEMORY = 0.1  # time constant of the filters: the velocity lags by twice this [s]
_JUMP, _TURN = 0.008, 0.03
"""A change in one period that differs from the one before by more than this is a jump [m, rad]."""
_STILL, _STILL_TURN = 0.02, 0.06
"""A velocity below this counts as 0, and one above twice this fully [m/s, rad/s]."""
_REST = 1e-9  # smaller filter states count as 0 [m, rad and per second]


class GoalVelocity:
    """Adds an estimated twist to goals without one; `period` is the control period [s]."""

    def __init__(self, period: float) -> None:
        self._period = period
        self.reset()

    def reset(self) -> None:
        """Forget the goal; the next one is at rest."""
        self._last: SE3 | None = None
        self._settled = False  # whether the goal is at rest and the filters have converged
        self._linear = _Filter(self._period, _JUMP, _STILL)
        self._angular = _Filter(self._period, _TURN, _STILL_TURN)

    def __call__(self, goal: PoseGoal) -> PoseGoal:
        """The goal with its estimated twist, unless it has one or is at rest."""
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
    """Rate (3,) of three numbers from their changes (3,) per period."""

    def __init__(self, period: float, jump: float, still: float) -> None:
        fading = exp(-period / _MEMORY)
        self._position_gain = 1.0 - fading * fading
        self._rate_gain = (1.0 - fading) ** 2 / period
        self._period, self._jump, self._still = period, jump, still
        self._last_change = np.zeros(3)
        self._forget()

    def _forget(self) -> None:
        self._behind = np.zeros(3)  # error of the filtered position
        self._rate = np.zeros(3)
        self.at_rest = True  # whether the filter has converged to rest

    def __call__(self, change: Array) -> Array | None:
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
