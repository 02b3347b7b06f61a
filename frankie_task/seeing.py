"""Seeing as a library: a depth image and its intrinsics in, ranked grasps out; no robot, no tree.

docs/seeing_library.md shows it in ten lines.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from hw import DepthFrame
from perception import GraspDetector
from robots import GripperDescription, Intrinsics, load_robot

__all__ = ["Grasp", "GraspFinder", "Grasps"]

_LOOKING_DOWN = SE3(np.diag([1.0, -1.0, -1.0]), np.zeros(3))
_LIFT = SE3(np.eye(3), np.array([0.0, 0.0, 100.0]))  # no floor is lower than 0 then [m]


@dataclass(frozen=True, kw_only=True, eq=False)
class Grasp:
    """One grasp of a parallel gripper."""

    pose: npt.NDArray[np.float64]
    """(4, 4) homogeneous, in the frame of `GraspFinder.__call__`: origin between the finger tips, z
    the approach, y the closing direction [m].
    """
    width: float  # of the object between the contacts [m]
    quality: float  # how likely the grasp holds, 0 to 1
    opening: float  # between the pads at which the hand comes down without touching [m]


@dataclass(frozen=True, kw_only=True, eq=False)
class Grasps:
    """The grasps in one depth image."""

    grasps: tuple[Grasp, ...]  # best first
    reason: str  # why there is none; empty if there is one


class GraspFinder:
    """Finds grasps in depth images of a camera that looks down, by less than 60 degrees aslant.

    Args:
        gripper: a robot with the hand, by name or file, or its description; the shipped networks
            are those of `frankie`, a Franka Hand.
        weights: of GG-CNN; None takes the shipped ones.

    Raises:
        UserError: robot or weights cannot be read.
    """

    def __init__(
        self, gripper: str | GripperDescription = "frankie", weights: Path | None = None
    ) -> None:
        hand = load_robot(gripper).gripper if isinstance(gripper, str) else gripper
        self._detector = GraspDetector.shipped(hand, weights)

    def __call__(
        self,
        depth: npt.NDArray[np.floating],
        K: npt.NDArray[np.floating],
        camera_pose: npt.NDArray[np.floating] | None = None,
    ) -> Grasps:
        """Grasps from straight above, everywhere over the largest level surface.

        Args:
            depth: (H, W) along the optical axis [m]; 0 or NaN where missing.
            K: (3, 3) intrinsics of the rectified image [px].
            camera_pose: (4, 4) of the camera (z along the optical axis, x right, y down) in a frame
                with z up, in which grasps are told then. None: it looks straight down, and grasps
                are told in its own frame.
        """
        told = _LOOKING_DOWN if camera_pose is None else SE3(np.asarray(camera_pose, dtype=float))
        rows, columns = depth.shape
        lens = Intrinsics(
            width=columns, height=rows, fx=K[0, 0], fy=K[1, 1], cx=K[0, 2], cy=K[1, 2]
        )
        frame = DepthFrame(depth=depth, intrinsics=lens, oTc=_LIFT * told, stamp=0.0)
        found = self._detector.detect(frame)
        back = (told.inverse() if camera_pose is None else SE3.Identity()) * _LIFT.inverse()
        return Grasps(
            grasps=tuple(
                Grasp(
                    pose=(back * one.oTg).homogeneous,
                    width=one.width,
                    quality=one.quality,
                    opening=one.opening,
                )
                for one in found.grasps
            ),
            reason=found.reason,
        )
