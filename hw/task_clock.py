"""The time of a task: the session's clock, which stands still while the task is paused."""

from __future__ import annotations

from hw import Clock


class TaskClock:
    """What the tree and its leaves read, so that a pause counts in none of their timeouts.

    Robot, gate and loop stay on the session's clock: they go on during a pause.

    Args:
        session: the session's clock.
    """

    def __init__(self, session: Clock) -> None:
        self.session = session
        self._left_out = 0.0
        self._held_at: float | None = None

    def now(self) -> float:
        """Seconds since the session began, without those in which it was held [s]."""
        if self._held_at is not None:
            return self._held_at
        return self.session.now() - self._left_out

    def sleep_until(self, stamp: float) -> None:
        """Return when `now()` is at least `stamp` [s]; not to be called while held."""
        self.session.sleep_until(stamp + self._left_out)

    def hold(self) -> None:
        """Stand still from now on."""
        if self._held_at is None:
            self._held_at = self.now()

    def release(self) -> None:
        """Go on from where it was held."""
        if self._held_at is not None:
            self._left_out = self.session.now() - self._held_at
            self._held_at = None
