"""Measurements of a run: limits and tick durations."""

from collections import Counter
from dataclasses import dataclass, field
from math import exp, log

import numpy as np

from hw import RobotState
from robots import Limits

_ROUNDING = 1e-9
_TRACKING = 0.01
"""Measured speeds may exceed a limit by this share; commands may not (the gate refuses them)."""
_LOG_BIN = 0.0199  # width of a histogram bin on the log scale; half of it is less than 1 %
TOO_SLOW = "this computer is too slow"
_WINDOW = 2.0  # of real time, in which the loop is compared with it [s]
_LOST_SHARE = 0.1  # of real time, from which the computer is too slow
_SHORTEST = 1e-9  # shorter durations count as this [s]


class Durations:
    """Histogram of durations on a log scale, in bounded memory; quantiles are within 1 %."""

    def __init__(self) -> None:
        self._counts: Counter[int] = Counter()

    def __len__(self) -> int:
        return self._counts.total()

    def append(self, seconds: float) -> None:
        """Count a duration [s]."""
        self._counts[round(log(max(seconds, _SHORTEST)) / _LOG_BIN)] += 1

    def quantile(self, share: float) -> float:
        """Duration that a share (0 to 1) of all does not exceed [s]; 0 if there is none."""
        remaining = share * len(self)
        for step in sorted(self._counts):
            remaining -= self._counts[step]
            if remaining <= 0:
                return exp(_LOG_BIN * step)
        return 0.0


@dataclass(kw_only=True, eq=False)
class Measurements:
    """Figures of a run so far, in bounded memory."""

    limits: Limits
    limit_violations: int = 0
    """Ticks with a measured joint position over its limit, or a speed by more than 1 %."""
    highest_speed: float = 0.0  # largest measured share of a speed limit
    smallest_margin: float = np.inf  # smallest distance of a joint to a position limit [rad]
    ticks_s: Durations = field(default_factory=Durations)
    """Real time of each tick from the reading to the command, without what threads do [s]."""
    late_ticks: int = 0  # ticks that took longer than the control period, observers included
    missed_ticks: int = 0  # ticks that were skipped because the one before took too long
    stalls: int = 0  # how often the watchdog stopped the robot because a tick took too long
    failed_stop: str = ""  # why it could not
    paused_s: float = 0.0  # real time that the run was paused [s]
    too_slow: str = ""  # that the computer has not kept real time of late, for people
    _time: tuple[float, float] = (0.0, 0.0)  # real time, and of it what was lost, so far [s]
    _window: tuple[float, float] = (0.0, 0.0)  # the same at the beginning of `_WINDOW`
    _robot_waits: bool = True

    def keep_time(self, real: float, lost: float, *, robot_waits: bool) -> None:
        """Compare the loop with real time.

        Args:
            real: time since the run began, without pauses [s].
            lost: how much of it a simulation fell behind, or ticks were left out [s].
            robot_waits: whether the robot is simulated, and its time waits for the loop.
        """
        self._time, self._robot_waits = (real, lost), robot_waits
        if real - self._window[0] >= _WINDOW:
            self.too_slow = self._told(self._window)
            self._window = self._time

    @property
    def too_slow_on_the_whole(self) -> str:
        """That the computer has not kept real time in this run, for people; else empty."""
        return self._told((0.0, 0.0))

    def _told(self, since: tuple[float, float]) -> str:
        real, lost = (now - before for now, before in zip(self._time, since, strict=True))
        share = lost / real if real > 0.0 else 0.0
        if share < _LOST_SHARE:
            return ""
        if self._robot_waits:
            return f"{TOO_SLOW} for real time: simulated at {1.0 - share:.2f} of it"
        return f"{TOO_SLOW}: {100.0 * share:.0f} % of the control ticks are left out"

    def reading(self, state: RobotState) -> None:
        """Compare a reading with the limits."""
        limits = self.limits
        margin = float(np.minimum(state.q - limits.q_min, limits.q_max - state.q).min())
        joint_share = float((np.abs(state.qd) / limits.qd).max())
        allowed = np.maximum(limits.base_speed(state.base_twist), _ROUNDING)
        base_share = float((np.abs(state.base_twist) / allowed).max())
        self.smallest_margin = min(self.smallest_margin, margin)
        self.highest_speed = max(self.highest_speed, joint_share, base_share)
        within = margin >= -_ROUNDING and max(joint_share, base_share) <= 1.0 + _TRACKING
        self.limit_violations += not within
