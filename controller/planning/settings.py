"""What may be tuned about planned motion."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

from controller.checked import Checked


@dataclass(frozen=True, kw_only=True)
class PlanningSettings(Checked):
    """How motions are planned, and how they are followed."""

    POSITIVE = ("speed_share", "acceleration_share", "checks", "gain")

    planning_time: float = 0.05
    """The robot stands for this long whenever a motion of the arm is planned [s]. It is charged
    instead of the time that this computer takes, so that the same seed is the same run."""
    checks: int = 6000
    """A search ends after so many postures that were checked for contact."""
    shortcuts: int = 60
    """Shortcuts that are tried on a path, each once more with random ends."""
    candidates: int = 4
    """Postures at the goal that are tried before there is no way."""
    clearance: float = 0.01
    """The arm keeps this far from what it could hit, where it does not come from or go to what is
    nearer [m]."""
    close_clearance: float = 0.001
    """The same where the hand may touch what is around [m]."""
    resolution: float = 0.03
    """Distance in joint space between two postures of a path that are checked [rad]."""
    straight_step: float = 0.01
    """Distance between two postures on a straight way of the hand [m]."""
    straight_jump: float = 0.35
    """No joint moves farther than this between the two [rad]."""
    speed_share: float = 0.95
    """Share of the joint speeds that a plan uses; the rest is left to correct ..."""
    acceleration_share: float = 0.85
    """... and of the joint accelerations."""
    gain: float = 5.0
    """Joint speed per distance to the plan [1/s]."""
    settled: float = 0.002
    """A plan is over when every joint is this near to its end [rad] ..."""
    patience: float = 0.6
    """... or so long after it [s]."""
    folded: float = 0.3
    """The arm is folded, so that the base may drive, this near to its ready posture [rad]."""
    drive_patience: float = 3.0
    """A base that comes no nearer for this long is stuck [s]."""
    attempts: int = 3
    """Plans for one goal, and stances, before it counts as out of reach."""
    other_goal: float = 0.05
    """A goal that has moved this far is another one [m] ..."""
    other_turn: float = radians(20.0)
    """... or has turned this far [rad]."""
