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
