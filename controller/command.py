"""Commands, motion goals, and the robot state that the controller reads.

An arm has j joints: positions are in rad, those of a sliding joint in m.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from typing import Any, Generic, NamedTuple, TypeAlias, cast

import numpy as np
import pinocchio as pin

from config.arrays import Array
from config.poses import MapFromOdometry, MapPose, OdometryPose, Pose


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
class PoseGoal(Generic[Pose]):
    """Bring the end effector to a pose with base and arm together."""

    target: Pose  # of the end effector: on the map for the controller, in odometry for a leaf
    twist: Array | None = None
    """(6,) velocity of the target in the axes of its frame, linear first [m/s, rad/s]; None
    estimates it from successive goals."""
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
    next_goal: Pose | None = None
    """Next end-effector pose: the base chooses its stance for it and leaves as early as the arm can
    still hold this goal. None keeps the base here."""

    @property
    def is_moving(self) -> bool:
        """Whether the goal is known to move."""
        return self.twist is not None and bool(self.twist.any())

    def on_map(self: PoseGoal[OdometryPose], mTo: MapFromOdometry) -> PoseGoal[MapPose]:
        """A goal in odometry, on the map."""
        return self._moved(mTo)

    def in_odometry(self: PoseGoal[MapPose], mTo: MapFromOdometry) -> PoseGoal[OdometryPose]:
        """A goal on the map, in odometry."""
        return self._moved(mTo.inverse())

    def _moved(self, T: Any) -> PoseGoal[Any]:
        twist, goal = self.twist, cast("PoseGoal[Any]", self)
        if twist is not None:
            twist = np.concatenate([T.rotation @ twist[:3], T.rotation @ twist[3:]])
        next_goal = None if self.next_goal is None else T * self.next_goal
        return replace(goal, target=T * self.target, twist=twist, next_goal=next_goal)


@dataclass(frozen=True, kw_only=True, eq=False)
class PostureGoal:
    """Bring the arm to joint positions with the base at rest."""

    q: Array  # (j,) desired joint positions [rad]
    tolerance: float = 0.01  # arrived when every joint is nearer than this [rad]

    def on_map(self, mTo: MapFromOdometry) -> PostureGoal:
        """The same: a posture does not depend on where the base is."""
        return self


@dataclass(frozen=True, kw_only=True, eq=False)
class BaseGoal(Generic[Pose]):
    """Bring the base to a pose on the floor with the arm at rest."""

    target: Pose  # of the base: on the map for the controller, in odometry for a leaf
    position_tolerance: float = 0.05  # arrived when nearer than this [m] ...
    heading_tolerance: float = np.deg2rad(5.0)  # ... and turned less than this away [rad]
    reverse: bool = False  # drive there backwards (differential drives)
    speed: float = inf  # largest speed of the base, if less than its own [m/s]

    def on_map(self: BaseGoal[OdometryPose], mTo: MapFromOdometry) -> BaseGoal[MapPose]:
        """A goal in odometry, on the map."""
        return replace(cast("BaseGoal[Any]", self), target=mTo * self.target)


MotionGoal: TypeAlias = PoseGoal[Pose] | PostureGoal | BaseGoal[Pose]


class KinematicState(NamedTuple):
    """What the controller reads of the robot."""

    mTb: MapPose  # base on the map
    q: Array  # (j,) arm joint positions [rad]


def after(state: KinematicState, command: Command, period: float) -> KinematicState:
    """The state of a robot that follows a command exactly for a period [s]."""
    vx, vy, turn = (command.base_twist * period).tolist()
    bTb = pin.exp6(np.array([vx, vy, 0.0, 0.0, 0.0, turn]))
    return KinematicState(state.mTb * bTb, state.q + command.qd * period)
