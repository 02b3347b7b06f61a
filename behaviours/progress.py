"""Whether a motion gets on: the one notion of progress of all behaviours that move."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from behaviours.context import Context
from controller import StepReport


class Progress:
    """Notices when a motion gets no further.

    A motion gets on while the hand, the base or the arm comes nearer to where the controller wants
    it than it ever was. One that does not is stuck as soon as the robot has stood still for
    `patience`; while it moves it may be on a way around, so that takes `detour_patience`, or
    `straight_patience` where it is to go straight and there is no way around. Only time in which
    the motion was asked about counts: pauses and late ticks do not, nor does waiting for somebody
    to pass. One to a goal that the controller calls unreachable is stuck at once.

    Args:
        context: what all leaves share.
        straight: whether the goal is to be reached straight.
    """

    def __init__(self, context: Context, *, straight: bool = False) -> None:
        self._context = context
        self._settings = settings = context.settings.progress
        self._patience = settings.straight_patience if straight else settings.detour_patience
        self._best = np.full(3, np.inf)
        self._last = context.clock.now()
        self._without = self._at_rest = 0.0
        self.because = ""
        """`: ` and why the goal cannot be reached, to be put behind what happened; empty if it is
        not known to be out of reach."""

    def is_stuck(self, report: StepReport) -> bool:
        """Ask once a tick, with the report about the goal of the last one."""
        if report.unreachable:
            self.because = f": {report.unreachable}"
            return True
        settings, now = self._settings, self._context.clock.now()
        passed = min(now - self._last, settings.longest_tick)
        self._last = now
        if report.waits_for:
            passed = 0.0
        left = self._left(report)
        self._without += passed
        self._at_rest = 0.0 if self._moves else self._at_rest + passed
        if (left < self._best - settings.step).any():
            self._best = np.minimum(left, self._best)
            self._without = self._at_rest = 0.0
        return self._at_rest > settings.patience or self._without > self._patience

    def _left(self, report: StepReport) -> npt.NDArray[np.float64]:
        """(3,) what hand, base and arm have left [m, s and rad]."""
        turn = self._settings.metres_per_radian * report.orientation_error
        return np.array([report.position_error + turn, report.base_time, report.posture_error])

    @property
    def _moves(self) -> bool:
        """Whether the robot moves, as read this tick."""
        state = self._context.state
        fastest = max(np.abs(state.qd).max(), np.abs(state.base_twist).max())
        return bool(fastest > self._settings.at_rest)
