"""The output of perception: grasps in the world and in the image."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from pinocchio import SE3


@dataclass(frozen=True, kw_only=True, eq=False)
class GraspEstimate:
    """One grasp, estimated from one frame."""

    wTg: SE3
    """Grasp in the world: origin between the tips, z the approach, y the closing direction."""
    width: float
    """Distance between the contacts along the closing direction [m]."""
    quality: float
    """0 to 1: how likely the grasp holds without a hard contact; where nobody tells that, the
    feasibility score times the square root of the network's, less penalties."""
    stamp: float
    """When the frame was captured [s]."""
    pixel: tuple[float, float]
    """(u, v) of the grasp centre in the full image [px]."""
    angle: float
    """Closing direction in the image, from u towards v [rad]."""
    opening: float
    """Distance between the pads for the descent, at which the fingers touch nothing [m]."""
    whole: bool = True
    """Whether the image shows all of what is grasped, and so how far its middle is."""
    depth: float = 0.0
    """Of the grasp centre below the surface [m]."""
    lever: float = 0.0
    """Level distance from the middle of the thing that is grasped [m]."""
    volume: float = 0.0
    """Of that thing, below its upper surface [m^3]."""
    middle: tuple[float, float] | None = None
    """x, y of the middle of that thing in the world [m]; None if the image does not show it all."""
    velocity: npt.NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    """(3,) of that thing in the world [m/s]; zeros as long as nobody has seen it move."""

    @property
    def twist(self) -> npt.NDArray[np.float64] | None:
        """(6,) how it moves, linear then angular [m/s, rad/s]; None if nobody has seen it move."""
        return np.concatenate([self.velocity, np.zeros(3)]) if self.velocity.any() else None

    def wTg_at(self, time: float) -> SE3:
        """Where the grasp is at a time [s], if it goes on as it moves."""
        return SE3(self.wTg.rotation, self.wTg.translation + (time - self.stamp) * self.velocity)


@dataclass(frozen=True, kw_only=True, eq=False)
class Detection:
    """The grasps found in one frame."""

    grasps: tuple[GraspEstimate, ...]
    """Best first."""
    reason: str
    """Why `grasps` is empty; empty when it is not."""
    quality: npt.NDArray[np.float32]
    """(300, 300) quality map of the network; 0 where depth was missing or outside the workspace."""
    crop: tuple[float, float, float]
    """(u0, v0, size) of the square of the full image that the quality map covers [px]."""
    occupied_area: float
    """Area from above that is at least `OCCUPIED_HEIGHT` above the workspace's floor [m^2]; NaN if
    the frame cannot be used."""
    stamp: float
    """When the frame was captured [s]."""
