"""Settings of planned motion."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

from controller.settings import Checked


@dataclass(frozen=True, kw_only=True)
class PlanningSettings(Checked):
    """How motions are planned, and how trajectories are followed."""

    POSITIVE = ("speed_share", "acceleration_share", "checks", "gain")

    planning_time: float = 0.05
    """The robot stands for this long whenever a motion of the arm is planned [s], instead of the
    real computing time, so that the same seed is the same run."""
    checks: int = 6000  # largest number of contact checks of a search
    shortcuts: int = 60  # number of shortcuts that are tried on a path
    candidates: int = 4  # largest number of postures at the goal that are tried
    clearance: float = 0.01  # clearance of the arm, except where it starts or ends nearer [m]
    close_clearance: float = 0.001  # the same where the hand may touch obstacles [m]
    resolution: float = 0.03
    """Joint-space distance between postures of a path that are checked [rad]."""
    straight_step: float = 0.01  # distance between postures on a straight line of the hand [m]
    straight_jump: float = 0.35  # largest joint motion between two of them [rad]
    speed_share: float = 0.95  # share of the joint speeds that a plan uses ...
    acceleration_share: float = 0.85  # ... and of the joint accelerations
    gain: float = 5.0  # gain of the joint errors [1/s]
    settled: float = 0.002  # largest joint error at the end of a plan [rad] ...
    patience: float = 0.6  # ... unless this time has passed after it [s]
    folded: float = 0.3
    """Largest joint distance to the ready posture at which the base may drive [rad]."""
    drive_patience: float = 3.0  # time without progress after which the base is stuck [s]
    attempts: int = 3  # largest number of plans, and of stances, for one goal
    other_goal: float = 0.05  # a goal that has moved this far is a new goal [m] ...
    other_turn: float = radians(20.0)  # ... or has turned this far [rad]
