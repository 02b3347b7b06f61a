"""What perception finds: grasps, in the world and in the image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from pinocchio import SE3


@dataclass(frozen=True, kw_only=True, eq=False)
class GraspEstimate:
    """One grasp, as seen in one frame."""

    wTg: SE3
    """Grasp in the world: origin between the tips, z the approach, y the closing direction."""
    width: float
    """Opening that the object needs between the finger pads [m]."""
    quality: float
    """How good it is held to be, 0 to 1: the network's word weighed by the check of the hand."""
    stamp: float
    """When the frame was captured [s]."""
    pixel: tuple[float, float]
    """(u, v) of the grasp centre in the full image [px]."""
    angle: float
    """Closing direction in the image, from u towards v [rad]."""
    opening: float = 0.08
    """Between the pads while the hand comes down, so that the fingers touch nothing [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Detection:
    """All that one frame tells about grasps."""

    grasps: tuple[GraspEstimate, ...]
    """Best first; empty if there is none."""
    reason: str
    """Why `grasps` is empty; empty when it is not."""
    quality: npt.NDArray[np.float32]
    """(300, 300) quality map of the network, 0 where depth was missing or out of the workspace."""
    crop: tuple[float, float, float]
    """(u0, v0, size) of the square of the full image that the quality map covers [px]."""
    occupied_area: float
    """Area, seen from above, of what stands at least 10 mm above the workspace's floor [m^2];
    NaN if the frame cannot be used."""
    stamp: float
    """When the frame was captured [s]."""
