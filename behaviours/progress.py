"""Whether a motion still comes nearer to its goal."""

from __future__ import annotations

from behaviours.settings import ProgressSettings
from controller import StepReport
from hw import TaskTime


class Progress:
    """Notices when a motion no longer comes nearer to its goal.

    Args:
        settings: what counts as nearer.
        patience: how long the error may stay without getting smaller [s]; None for the usual time.
    """

    def __init__(self, settings: ProgressSettings, patience: float | None = None) -> None:
        self._settings = settings
        self._patience = settings.patience if patience is None else patience
        self._best = float("inf")
        self._since: TaskTime | None = None

    def is_stuck(self, report: StepReport, now: TaskTime) -> bool:
        """Whether the way to a pose, position and orientation together, gets no shorter."""
        angle = self._settings.metres_per_radian * report.orientation_error
        return self.stalled(report.position_error + angle, now)

    def stalled(self, error: float, now: TaskTime) -> bool:
        """Whether the best error so far [m or rad] is older than the patience allows."""
        if self._since is None or error < self._best - self._settings.step:
            self._best, self._since = error, now
        return now - self._since > self._patience
