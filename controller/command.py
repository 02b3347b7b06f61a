"""Commands, motion goals, and the robot state that the controller reads.

An arm has j joints: positions are in rad, those of a sliding joint in m.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from typing import Protocol, TypeAlias

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

Array: TypeAlias = npt.NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Command:
    """Velocities of base and arm for one control period."""

    base_twist: Array  # (3,) vx, vy, ω in the base frame [m/s, m/s, rad/s]; vy is 0 if differential
    qd: Array  # (j,) arm joint velocities [rad/s]

    @classmethod
    def stop(cls, j: int) -> Command:
        """The command to stand still, for an arm of j joints."""
        return cls(base_twist=np.zeros(3), qd=np.zeros(j))

    def is_finite(self) -> bool:
        """True if every component is a finite number."""
        return bool(np.isfinite(self.base_twist).all() and np.isfinite(self.qd).all())


@dataclass(frozen=True, kw_only=True, eq=False)
class PoseGoal:
    """Bring the end effector to a pose in the world with base and arm together."""

    wTe: SE3  # desired end-effector pose in the world
    twist: Array | None = None
    """(6,) velocity of the goal in world axes, linear first [m/s, rad/s]; None estimates it from
    successive goals."""
    speed: float = 1.5  # largest speed of the end effector, and of the base on its way [m/s]
    turn_rate: float = 2.0  # largest end-effector rotation rate [rad/s]
    position_tolerance: float = 0.01  # arrived when nearer than this [m] ...
    orientation_tolerance: float = np.deg2rad(2.0)  # ... and turned less than this away [rad]
    straight: bool = False  # move the end effector in a straight line: no detour after a stall
    stance_if_near: bool = False
    """Lead base and arm to a stance even for a near goal, where the end effector alone would get
    stuck."""
    hand_may_touch: bool = False
    """Let the hand and what it holds touch obstacles, as to grasp from a container or to set
    something down. Palm and arm keep their distance."""
    base_rests: bool = False
    """Move the arm alone as far as it reaches: odometry is the less exact the farther the base
    drives."""
    next_goal: SE3 | None = None
    """Next end-effector pose: the base chooses its stance for it and leaves as early as the arm can
    still hold this goal. None keeps the base here."""

    @property
    def is_moving(self) -> bool:
        """Whether the goal is known to move."""
        return self.twist is not None and bool(self.twist.any())

    def moved(self, T: SE3) -> PoseGoal:
        """The goal, moved by T."""
        twist = self.twist
        if twist is not None:
            twist = np.concatenate([T.rotation @ twist[:3], T.rotation @ twist[3:]])
        next_goal = None if self.next_goal is None else T * self.next_goal
        return replace(self, wTe=T * self.wTe, twist=twist, next_goal=next_goal)


@dataclass(frozen=True, kw_only=True, eq=False)
class PostureGoal:
    """Bring the arm to joint positions with the base at rest."""

    q: Array  # (j,) desired joint positions [rad]
    tolerance: float = 0.01  # arrived when every joint is nearer than this [rad]

    def moved(self, T: SE3) -> PostureGoal:
        """The same: a posture does not depend on where the base is."""
        return self


@dataclass(frozen=True, kw_only=True, eq=False)
class BaseGoal:
    """Bring the base to a pose on the floor with the arm at rest."""

    wTb: SE3  # desired base pose in the world
    position_tolerance: float = 0.05  # arrived when nearer than this [m] ...
    heading_tolerance: float = np.deg2rad(5.0)  # ... and turned less than this away [rad]
    reverse: bool = False  # drive there backwards (differential drives)
    speed: float = inf  # largest speed of the base, if less than its own [m/s]

    def moved(self, T: SE3) -> BaseGoal:
        """The goal, moved by T."""
        return replace(self, wTb=T * self.wTb)


MotionGoal: TypeAlias = PoseGoal | PostureGoal | BaseGoal


class KinematicState(Protocol):
    """The part of the robot's state that the controller reads; `hw.RobotState` has it."""

    @property
    def wTb(self) -> SE3:
        """Base pose in the world."""

    @property
    def q(self) -> Array:
        """(j,) arm joint positions [rad]."""
