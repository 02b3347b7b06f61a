"""What stands behind the emulated controller: something that moves as its wheels are told."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, sin
from typing import Protocol

from hw.clock import stopwatch


class Drive(Protocol):
    """The wheels and the world; called every 10 ms from the emulator's thread."""

    def command(self, v: float, w: float) -> None:
        """Move at these velocities from now on [m/s, rad/s]."""

    def pose(self) -> tuple[float, float, float]:
        """True x, y and heading in the world [m, m, rad]."""

    def twist(self) -> tuple[float, float]:
        """True velocities [m/s, rad/s]."""


class Unicycle:
    """An empty, flat world: wheels that do at once what they are told.

    Args:
        pose: where it begins: x, y and heading [m, m, rad].
        now: time [s].
    """

    def __init__(
        self,
        pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
        now: Callable[[], float] = stopwatch,
    ) -> None:
        self._now = now
        self._at = now()
        self._pose = pose
        self._twist = (0.0, 0.0)

    def command(self, v: float, w: float) -> None:
        """Move at these velocities from now on [m/s, rad/s]."""
        self._pose = self.pose()
        self._twist = (v, w)

    def pose(self) -> tuple[float, float, float]:
        """Where it is: x, y and heading [m, m, rad]."""
        x, y, theta = self._pose
        (v, w), now = self._twist, self._now()
        dt, self._at = now - self._at, now
        middle = theta + w * dt / 2.0
        self._pose = (x + v * dt * cos(middle), y + v * dt * sin(middle), theta + w * dt)
        return self._pose

    def twist(self) -> tuple[float, float]:
        """The velocities that it was told [m/s, rad/s]."""
        return self._twist
