"""What one control step measured and achieved."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from pinocchio import SE3

from controller.command import Array
from controller.floor import Pose2D


@dataclass(frozen=True, kw_only=True, eq=False)
class StepReport:
    """What one control step measured and achieved."""

    arrived: bool
    """Whether the goal is reached within its tolerances; False without a goal."""
    position_error: float
    """Distance to the goal [m]; 0 for a posture, NaN without a goal."""
    orientation_error: float
    """Angle to the goal, for a posture the largest joint error [rad]; NaN without a goal."""
    manipulability: float
    """Yoshikawa's measure of the arm."""
    heading_error: float
    """θ_ε: bearing of the end effector seen from the base [rad]."""
    slack: float
    """|δ|: norm of the end-effector twist that was desired and not achieved [m/s and rad/s]."""
    solved: bool
    """Whether the QP was solved; if not, the command brakes."""
    bTe: SE3
    """End effector in the base."""
    base_time: float = 0.0
    """Least time in which the base gets to its goal, or to where the guidance wants it [s]; 0 where
    it has no place of its own to go to."""
    posture_error: float = 0.0
    """Largest joint error to the goal's posture, or to that of the guidance [rad]; 0 without."""
    unreachable: str = ""
    """Why the robot cannot get to the goal; empty if it can, as far as is known."""
    stance: Pose2D | None = None
    """Where the guidance wants the base; None if the end effector goes alone."""
    blend: float = 0.0
    """s in [0, 1]: 0 leaves all to the end effector, 1 nearly all to base and arm."""
    detour: bool = False
    """Whether that is a way around, after a stall."""
    clearance: float = inf
    """Distance between the robot and what is nearest to it, if that is near [m]."""
    near_pairs: int = 0
    """Pairs of shapes, of which one is the robot's, that are so near to each other that they matter
    at their speed."""
    nearest: str = ""
    """What comes nearest to what, for people; empty if nothing is near."""
    nearest_points: tuple[Array, Array] | None = None
    """The two points (3,), in the world, between which that distance was measured last; None if
    nothing is near, or only points that a camera has seen."""
    way: Array | None = None
    """(N, 3) base poses on the way around what stands there; the same object as long as it is the
    same way. None if the base goes without one."""
    waits_for: str = ""
    """Who moves nearest, while the robot gives way; empty if it need not."""
    planning: bool = False
    """Whether the robot stands because its motion is being planned."""
