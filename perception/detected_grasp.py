"""Results of grasp detection, in odometry and in the image."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from pinocchio import SE3

from config.arrays import Array, Image
from config.poses import OdometryPose


@dataclass(frozen=True, kw_only=True, eq=False)
class GraspEstimate:
    """One grasp, estimated from one frame."""

    oTg: OdometryPose  # origin between the finger tips, z the approach, y the closing direction
    width: float  # distance between the contacts along the closing direction [m]
    quality: float
    """0 to 1: how likely the grasp holds without a hard contact; without an estimate of that, the
    feasibility score times the square root of the network's, less penalties.
    """
    stamp: float  # time of capture [s]
    pixel: tuple[float, float]  # (u, v) of the grasp centre in the full image [px]
    angle: float  # closing direction in the image, from u towards v [rad]
    opening: float  # distance between the pads at which the fingers touch nothing [m]
    whole: bool = True  # whether the image shows all of the object, and so its middle
    depth: float = 0.0  # of the grasp centre below the surface [m]
    lever: float = 0.0  # distance from the middle of the object, across the approach [m]
    volume: float = 0.0  # of the object, behind the surface that the hand meets [m^3]
    middle: tuple[float, float] | None = None
    """x, y of the middle of the object in odometry [m]; None if the image does not show it all,
    and of a grasp that is not from straight above: only so are objects followed that move.
    """
    outline: Array | None = None
    """(K, 3) corners in g, at z = 0, of the convex hull of the object and of what touches it [m];
    None if the image does not show it all.
    """
    velocity: Array = field(default_factory=lambda: np.zeros(3))
    """(3,) of the object in odometry [m/s]; zeros as long as it was not seen to move."""

    @property
    def twist(self) -> Array | None:
        """(6,) linear then angular [m/s, rad/s]; None if it was not seen to move."""
        return np.concatenate([self.velocity, np.zeros(3)]) if self.velocity.any() else None

    def oTg_at(self, time: float) -> OdometryPose:
        """The grasp pose at a time [s] at constant velocity."""
        travelled = (time - self.stamp) * self.velocity
        moved: OdometryPose = SE3(self.oTg.rotation, self.oTg.translation + travelled)
        return moved


@dataclass(frozen=True, kw_only=True, eq=False)
class Detection:
    """The grasps found in one frame."""

    grasps: tuple[GraspEstimate, ...]  # best first
    reason: str  # why `grasps` is empty; empty when it is not
    quality: Image
    """(300, 300) map of the first source, a network; 0 without depth or outside the workspace."""
    crop: tuple[float, float, float]  # (u0, v0, size) of the part of the image that it covers [px]
    stamp: float  # time of capture [s]
