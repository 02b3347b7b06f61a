"""What is measured on every tick: limits from the readings, and the time it took."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from app.core.durations import Durations
from hw import RobotState
from robots import Limits

_ROUNDING = 1e-9
_FOLLOWING = 0.01
"""Share of a speed limit that a reading may be over it, by how well motors follow; commands may
not: the gate sees to it."""


@dataclass(kw_only=True, eq=False)
class Measurements:
    """Figures of a run so far; their memory does not grow with it.

    Args:
        limits: what the readings are held against.
    """

    limits: Limits
    limit_violations: int = 0
    """Ticks in which a measured joint position was over its limit, or a speed by more than 1 %."""
    highest_speed: float = 0.0
    """Largest measured share of a speed limit so far."""
    smallest_margin: float = np.inf
    """Nearest that a joint came to a position limit [rad]."""
    ticks_s: Durations = field(default_factory=Durations)
    """Real time of each tick from the reading to the command, perception in step included [s]."""
    late_ticks: int = 0
    """Ticks that took longer than the control period, what they tell watchers included."""
    missed_ticks: int = 0
    """Ticks that were left out, because the one before took longer than its period."""
    stalls: int = 0
    """How often the watchdog stopped the robot because a tick took too long."""
    paused_s: float = 0.0
    """Real time that the run was paused [s]."""

    def reading(self, state: RobotState) -> None:
        """Hold a reading against the limits."""
        limits = self.limits
        margin = float(np.minimum(state.q - limits.q_min, limits.q_max - state.q).min())
        joint_share = float((np.abs(state.qd) / limits.qd).max())
        allowed = np.maximum(limits.base_speed(state.base_twist), _ROUNDING)
        base_share = float((np.abs(state.base_twist) / allowed).max())
        self.smallest_margin = min(self.smallest_margin, margin)
        self.highest_speed = max(self.highest_speed, joint_share, base_share)
        within = margin >= -_ROUNDING and max(joint_share, base_share) <= 1.0 + _FOLLOWING
        self.limit_violations += not within
