"""First-order lag of the mobile base, which the arm compensates for.

Base and joints follow a command with first-order lags, and the base with the longer one. A base
that brakes by 1 m/s² with a lag of 0.1 s is 0.1 m/s faster than commanded, which would put an end
effector on a straight line off by 25 mm at a gain of 4 / s.
"""

from __future__ import annotations

from math import exp

import numpy as np

from controller.command import Array
from controller.model import RobotModel


class BaseLag:
    """Predicts the velocity of the base from its commands; `period` is the control period [s]."""

    def __init__(self, model: RobotModel, period: float) -> None:
        base, arm = model.description.base.lag, model.description.arm.lag
        self.response = 1.0 - exp(-period / base)
        """Share of a commanded change of velocity that the base has taken up after one period."""
        self._lead = 1.0 - exp(-arm / base)
        self.commanded = np.zeros(model.n_base)  # (n_base,) velocities of the last command
        self._now: Array | None = None

    def update(self, commanded: Array) -> None:
        """Note the base velocities (n_base,) that were commanded in the last period."""
        before = commanded if self._now is None else self._now
        self.commanded, self._now = commanded, before + self.response * (commanded - before)

    @property
    def velocity(self) -> Array:
        """(n_base,) once the joints have followed, if the same is commanded again."""
        now = self.commanded if self._now is None else self._now
        return now + self._lead * (self.commanded - now)

    def surplus(self, commanded: Array) -> Array:
        """(n_base,) by which the base is faster then than it is commanded now, (n_base,)."""
        now = commanded if self._now is None else self._now
        return (1.0 - self._lead) * (now - commanded)
