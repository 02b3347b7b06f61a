"""Grasps from depth: GG-CNN proposes, a check of the hand against the measured depth disposes.

`GraspDetector` turns one depth frame into ranked grasps in the world, `GraspTracker` follows one of
them from frame to frame until the camera is so near that the goal had better not move any more.
Frames come in by shape alone (`Frame`, `Workspace`), so that any camera will do.
"""

from perception.detector import OCCUPIED_HEIGHT, WALL_MARGIN, GraspDetector
from perception.frame import Frame, Intrinsics, Workspace
from perception.geometry import world_points
from perception.grasp import Detection, GraspEstimate
from perception.maps import WeightsError
from perception.tracker import GraspTracker

__all__ = [
    "OCCUPIED_HEIGHT",
    "WALL_MARGIN",
    "Detection",
    "Frame",
    "GraspDetector",
    "GraspEstimate",
    "GraspTracker",
    "Intrinsics",
    "WeightsError",
    "Workspace",
    "world_points",
]
