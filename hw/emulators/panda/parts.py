"""The bodies behind the emulator, seven joints and two fingers: a seam for a simulated world."""

from __future__ import annotations

from math import copysign, exp
from typing import Protocol

PERIOD = 0.001
"""Of the arm's own clock [s]."""
READY = (0.0, -0.3, 0.0, -2.2, 0.0, 2.0, 0.7853981633974483)
"""Where joints begin if nobody says otherwise [rad]."""
_LAG = 0.025
"""Time constant with which joints follow [s]."""
OPENING = 0.08
"""Between the fingers when fully open [m]."""


class Joints(Protocol):
    """Seven joints that follow velocities."""

    q: tuple[float, ...]
    """(7,) positions [rad]."""
    qd: tuple[float, ...]
    """(7,) velocities [rad/s]."""

    def follow(self, qd: tuple[float, ...]) -> str:
        """Go on for one period with commanded velocities (7,) [rad/s].

        Returns:
            The error with which the arm stops because it has met something, of `ERRORS`; or empty.
        """

    def release(self) -> None:
        """The arm was recovered: what it has met is forgotten."""


class Fingers(Protocol):
    """Two fingers, and perhaps something between them."""

    @property
    def width(self) -> float:
        """Between the pads [m]."""

    def close_to(self, width: float, step: float, force: float) -> bool:
        """Go on towards a width by at most a step [m], pressing with a force [N].

        Returns:
            Whether they can come no closer.
        """

    def stop(self) -> None:
        """Stay where they are."""


class LaggedJoints:
    """Joints in free air; velocities follow with a lag of first order.

    Args:
        q: (7,) where they begin [rad].
        lag: its time constant [s].
    """

    def __init__(self, q: tuple[float, ...] = READY, lag: float = _LAG) -> None:
        self.q = q
        self.qd: tuple[float, ...] = (0.0,) * 7
        self._share = 1.0 - exp(-PERIOD / lag)

    def follow(self, qd: tuple[float, ...]) -> str:
        """One period; there is nothing to meet."""
        share = self._share
        self.qd = tuple([v + share * (w - v) for v, w in zip(self.qd, qd, strict=True)])
        self.q = tuple([p + PERIOD * v for p, v in zip(self.q, self.qd, strict=True)])
        return ""

    def release(self) -> None:
        """There is nothing to forget."""


class FreeFingers:
    """Fingers with nothing between them, or a block of some width.

    Args:
        block: what lies between the fingers [m]; None for nothing.
        width: where they begin [m].
    """

    def __init__(self, block: float | None = None, width: float = OPENING) -> None:
        self.block, self.width = block, width

    def stop(self) -> None:
        """They do not move by themselves."""

    def close_to(self, width: float, step: float, force: float) -> bool:
        """A step of the fingers."""
        least = width
        if self.block is not None and self.width >= self.block:
            least = max(width, self.block)
        way = least - self.width
        self.width = least if abs(way) <= step else self.width + copysign(step, way)
        return self.width == least
