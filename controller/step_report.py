"""The report of one control step."""

from math import inf
from typing import NamedTuple

from pinocchio import SE3

from config.planar import Pose2D
from controller.command import Array


class StepReport(NamedTuple):
    """What one control step measured and achieved."""

    arrived: bool  # whether the goal is reached within its tolerances; False without a goal
    position_error: float  # distance to the goal [m]; 0 for a posture, NaN without a goal
    orientation_error: float  # angle to the goal or largest joint error [rad]; NaN without a goal
    manipulability: float  # Yoshikawa's measure of the arm
    heading_error: float  # θ_ε: bearing of the end effector seen from the base [rad]
    bTe: SE3  # end effector in the base
    slack: float = 0.0  # norm of the twist that the command leaves of the desired one [m/s, rad/s]
    solved: bool = True  # whether the QP was solved; if not, the command brakes
    base_time: float = 0.0  # least time of the base to its goal or stance [s]; 0 without one
    posture_error: float = 0.0
    """Largest joint error to the posture of the goal or the stance [rad]; 0 without one."""
    unreachable: str = ""  # why the robot cannot get to the goal; empty if it can, as far as known
    stance: Pose2D | None = None  # base pose of the stance; None if there is none
    blend: float = 0.0  # s in [0, 1]: 0 leaves the motion to the end effector, 1 to base and arm
    detour: bool = False  # whether the stance is a detour after a stall
    clearance: float = inf  # distance between robot and nearest obstacle, if one is near [m]
    nearest: str = ""  # the parts that `clearance` is between; empty if nothing is near
    nearest_points: tuple[Array, Array] | None = None
    """The two points (3,) on the map that `clearance` is between; None if nothing is near, or
    only depth points."""
    way: Array | None = None
    """(N, 3) base poses of the planned path, the same object as long as it is the same path. None
    if the base has none."""
    waits_for: str = ""  # the nearest moving obstacle while the robot gives way; else empty
    shortfall: float = 0.0  # most by which the command misses a row of `Constraints.keep`, else 0
