"""How fast the base still is: it takes up a velocity late, and the arm makes up for it meanwhile.

Base and joints follow a command with first-order lags, the base with much the longer one. While it
brakes by 1 m/s² with a lag of 0.1 s it is 0.1 m/s faster than it is told. A hand that is to go down
a straight line would be 25 mm beside it, at a gain of 4 / s.
"""

from __future__ import annotations

from math import exp

import numpy as np

from controller.command import Array
from controller.model import RobotModel


class BaseLag:
    """The velocity that the base has, as far as its lag tells.

    Args:
        model: the robot.
        period: of the controller [s].
    """

    def __init__(self, model: RobotModel, period: float) -> None:
        base, arm = model.description.base.lag, model.description.arm.lag
        self.response = 1.0 - exp(-period / base)
        """Share of a change of its velocity that the base has taken up after one period."""
        self._lead = 1.0 - exp(-arm / base)
        self.told = np.zeros(model.n_base)
        """(n_base,) velocities of the last command."""
        self._now: Array | None = None

    def follow(self, told: Array) -> None:
        """Note what the base was told in the last period: (n_base,) velocities."""
        before = told if self._now is None else self._now
        self.told, self._now = told, before + self.response * (told - before)

    @property
    def velocity(self) -> Array:
        """(n_base,) by the time the joints follow, if the base is told the same once more."""
        now = self.told if self._now is None else self._now
        return now + self._lead * (self.told - now)

    def surplus(self, told: Array) -> Array:
        """(n_base,) by how much it is faster then than it is told now, (n_base,)."""
        now = told if self._now is None else self._now
        return (1.0 - self._lead) * (now - told)
