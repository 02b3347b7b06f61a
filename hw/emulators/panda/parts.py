"""Joints and fingers behind the emulated Panda; a simulated world can replace them."""

from __future__ import annotations

from math import copysign, exp
from typing import Protocol

PERIOD = 0.001  # of the control loop [s]
READY = (0.0, -0.3, 0.0, -2.2, 0.0, 2.0, 0.7853981633974483)  # initial positions [rad]
_LAG = 0.025  # time constant of the joints [s]
OPENING = 0.08  # between the fingers when fully open [m]


class Joints(Protocol):
    """Seven joints that follow velocities."""

    q: tuple[float, ...]  # (7,) positions [rad]
    qd: tuple[float, ...]  # (7,) velocities [rad/s]

    def follow(self, qd: tuple[float, ...]) -> str:
        """Advance by one period with commanded velocities (7,) [rad/s].

        Returns:
            The error of a contact that stops the arm, of `ERRORS`; or empty.
        """

    def release(self) -> None:
        """Forget a contact after a recovery."""


class Fingers(Protocol):
    """Two fingers, possibly with an object between them."""

    @property
    def width(self) -> float:
        """Between the pads [m]."""

    def close_to(self, width: float, step: float, force: float) -> bool:
        """Move towards a width by at most a step [m] with a force [N]; whether they rest."""

    def stop(self) -> None:
        """Stop where they are."""


class LaggedJoints:
    """Joints in free air; velocities follow with a first-order lag."""

    def __init__(self, q: tuple[float, ...] = READY) -> None:
        self.q = q
        self.qd: tuple[float, ...] = (0.0,) * 7
        self._share = 1.0 - exp(-PERIOD / _LAG)

    def follow(self, qd: tuple[float, ...]) -> str:
        """Advance by one period; there are no contacts."""
        share = self._share
        self.qd = tuple([v + share * (w - v) for v, w in zip(self.qd, qd, strict=True)])
        self.q = tuple([p + PERIOD * v for p, v in zip(self.q, self.qd, strict=True)])
        return ""

    def release(self) -> None:
        """There are no contacts."""


class FreeFingers:
    """Fingers with nothing, or a block of some width [m], between them."""

    def __init__(self) -> None:
        self.block: float | None = None
        self.width = OPENING

    def stop(self) -> None:
        """They move only when commanded."""

    def close_to(self, width: float, step: float, force: float) -> bool:
        """Advance by one step."""
        least = width
        if self.block is not None and self.width >= self.block:
            least = max(width, self.block)
        way = least - self.width
        self.width = least if abs(way) <= step else self.width + copysign(step, way)
        return self.width == least
