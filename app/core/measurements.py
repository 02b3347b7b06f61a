"""What is measured on every tick: limits from the readings, the commands, the time it took."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from controller import Command
from hw import RobotState
from robots import Limits

_ROUNDING = 1e-9


@dataclass(kw_only=True, eq=False)
class Measurements:
    """Grows by one row a tick.

    Args:
        limits: what the readings are held against.
    """

    limits: Limits
    limit_violations: int = 0
    """Ticks in which a measured joint position, joint speed or base speed was over its limit."""
    highest_speed: float = 0.0
    """Largest measured share of a speed limit so far."""
    smallest_margin: float = np.inf
    """Nearest that a joint came to a position limit [rad]."""
    ticks_s: list[float] = field(default_factory=list)
    """Real time of each tick from the reading to the command, perception in step included [s]."""
    late_ticks: int = 0
    """Ticks that took longer than the control period, what they tell watchers included."""
    missed_ticks: int = 0
    """Ticks that were left out, because the one before took longer than its period."""
    stalls: int = 0
    """How often the watchdog stopped the robot because a tick took too long."""
    paused_s: float = 0.0
    """Real time that the run was paused [s]."""
    _commands: list[npt.NDArray[np.float64]] = field(default_factory=list)
    _states: list[npt.NDArray[np.float64]] = field(default_factory=list)

    def reading(self, state: RobotState) -> None:
        """Keep a reading and hold it against the limits."""
        limits = self.limits
        x, y, _ = state.wTb.translation
        heading = np.arctan2(state.wTb.rotation[1, 0], state.wTb.rotation[0, 0])
        base = (state.stamp, x, y, heading, *state.base_twist)
        self._states.append(np.array([*base, *state.q, *state.qd, state.gripper_width]))
        margin = float(np.minimum(state.q - limits.q_min, limits.q_max - state.q).min())
        joint_share = float((np.abs(state.qd) / limits.qd).max())
        allowed = np.maximum(limits.base_speed(state.base_twist), _ROUNDING)
        base_share = float((np.abs(state.base_twist) / allowed).max())
        self.smallest_margin = min(self.smallest_margin, margin)
        self.highest_speed = max(self.highest_speed, joint_share, base_share)
        within = margin >= -_ROUNDING and max(joint_share, base_share) <= 1.0 + _ROUNDING
        self.limit_violations += not within

    def command(self, stamp: float, applied: Command) -> None:
        """Keep what the robot applied."""
        self._commands.append(np.array([stamp, *applied.base_twist, *applied.qd]))

    @property
    def commands(self) -> npt.NDArray[np.float64]:
        """(ticks, 11): stamp [s], base twist (3), joint velocities (7)."""
        return np.array(self._commands).reshape(-1, 11)

    @property
    def states(self) -> npt.NDArray[np.float64]:
        """(ticks, 22): stamp [s], base x, y, heading, base twist (3), q (7), qd (7), width."""
        return np.array(self._states).reshape(-1, 22)
