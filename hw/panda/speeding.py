"""Joints that move faster than they were told: what is measured against what was commanded."""

from __future__ import annotations

from collections.abc import Sequence

_MARGIN = 0.25
"""By how much a joint may be faster than it was told [rad/s] ..."""
_PATIENCE = 0.2
"""... and for how long it may be faster than that [s]."""
_FADING = 0.99
"""Joints follow late: what they were told counts on, and becomes this share in each period."""
_ZERO = (0.0,) * 7


class SpeedingError(Exception):
    """A joint moves faster than it was told."""


class Speeding:
    """Compares the speeds of the joints in one motion."""

    def __init__(self) -> None:
        self._told: Sequence[float] = _ZERO
        self._fastest: Sequence[float] = _ZERO
        self._since: float | None = None

    def check(self, now: float, measured: Sequence[float], next_told: Sequence[float]) -> None:
        """Once a period.

        Args:
            now: [s].
            measured: (7,) velocities [rad/s].
            next_told: (7,) velocities that are commanded from now on [rad/s].

        Raises:
            SpeedingError: one has been too fast for too long; the arm is to be stopped.
        """
        told, self._told = self._told, next_told
        rows = zip(told, self._fastest, strict=True)
        self._fastest = fastest = [max(abs(qd), _FADING * before) for qd, before in rows]
        beyond = [abs(qd) - most for qd, most in zip(measured, fastest, strict=True)]
        worst = max(beyond)
        if worst <= _MARGIN:
            self._since = None
        elif self._since is None:
            self._since = now
        elif now - self._since > _PATIENCE:
            joint = beyond.index(worst)
            raise SpeedingError(
                f"joint {joint + 1} moved at {measured[joint]:.2f} rad/s and was told "
                f"{told[joint]:.2f} rad/s: something pushes it, or the masses in Desk are wrong; "
                "look, then recover"
            )
