"""What stops a part of the robot on a force: filtered, and forgiven only as far as it goes."""

from __future__ import annotations

import numpy as np

from robots import Array

_MARGIN = 15.0
"""While the robot leaves a contact that was forgiven, it may press this much harder [N]."""


class ForceReflex:
    """Trips on a force above a limit.

    Clearing it forgives the force that is left: the robot may slide along what it touches, and away
    from it. What is forgiven shrinks with the force, down to the limit.

    Args:
        limit: [N].
    """

    def __init__(self, limit: float) -> None:
        self.reason: str | None = None
        """What it tripped on, for people; None while the part may move."""
        self.towards: Array = np.zeros(3)
        """(3,) unit vector from the robot to what it tripped on, in the world; 0 if not known."""
        self._limit = limit
        self._allowed = limit
        self._force = 0.0

    def feels(self, force: float) -> bool:
        """Whether a force [N] stops the part now."""
        self._force = force
        self._allowed = max(self._limit, min(self._allowed, force + _MARGIN))
        return self.reason is None and force > self._allowed

    def trip(self, reason: str, towards: Array | None = None) -> None:
        """Stop the part on what is `towards` (3,) of it, in the world."""
        self.reason = reason
        self.towards = np.zeros(3) if towards is None else towards

    def clear(self) -> None:
        """Let the part move again."""
        self.reason = None
        self._allowed = max(self._limit, self._force + _MARGIN)
