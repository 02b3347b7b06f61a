"""Scenes turned so that the hand approaches from straight above: the frame a of an approach.

Frame a has the world's origin, and the hand approaches along its -z; `wRa` (3, 3) is its rotation
in the world. In a, every approach is from straight above, only that level surfaces are slopes.
"""

from dataclasses import dataclass

import numpy as np
from pinocchio import SE3

from perception.frame import Array, Frame, Image, Mask, ObjectRegion, Workspace
from robots import Intrinsics

_MOST_SLANT = 0.35  # sine of the slant of a closing direction from which on it counts as ...
_LEAST_UPRIGHT = 0.3  # ... this much


@dataclass(frozen=True, kw_only=True, eq=False)
class FrameAlong:
    """A `Frame` with the camera in a."""

    depth: Image
    intrinsics: Intrinsics
    wTc: SE3  # camera in a
    stamp: float


class WorkspaceAlong:
    """A `Workspace` whose points are in a; its floor is still level in the world."""

    def __init__(self, workspace: Workspace, wRa: Array) -> None:
        self._workspace, self._aRw = workspace, wRa.T
        self.floor = workspace.floor

    def contains(self, points: Array) -> Mask:
        """See `Workspace`."""
        return self._workspace.contains(points @ self._aRw)


class ObjectsAlong(WorkspaceAlong):
    """An `ObjectRegion` whose points are in a."""

    def __init__(self, workspace: ObjectRegion, wRa: Array) -> None:
        super().__init__(workspace, wRa)
        self._objects = workspace

    def owns(self, centres: Array, contacts: Array, pads: Array) -> Mask:
        """See `ObjectRegion`."""
        aRw = self._aRw
        return self._objects.owns(centres @ aRw, contacts @ aRw, pads @ aRw)


def level_direction(wRa: Array) -> float:
    """The closing direction in a that is level in the world, from x towards y [rad]."""
    return float(np.arctan2(-wRa[2, 0], wRa[2, 1]))


def uprightness(direction: Array, wRa: Array | None) -> Array:
    """(N,) 1 for closing directions in a that are level in the world, to 0.3 for slanted ones.

    The sides of most objects are upright: pads that close on them at a slant turn the object.
    """
    if wRa is None:
        return np.ones(len(direction))
    slant = np.cos(direction) * wRa[2, 0] + np.sin(direction) * wRa[2, 1]
    lost = (1.0 - _LEAST_UPRIGHT) * np.minimum((slant / _MOST_SLANT) ** 2, 1.0)
    upright: Array = 1.0 - lost
    return upright


def frame_along(frame: Frame, wRa: Array | None) -> Frame:
    """A frame in a; itself for None, from straight above."""
    if wRa is None:
        return frame
    aTc = SE3(wRa.T, np.zeros(3)) * frame.wTc
    return FrameAlong(depth=frame.depth, intrinsics=frame.intrinsics, wTc=aTc, stamp=frame.stamp)


def workspace_along(workspace: Workspace | None, wRa: Array | None) -> Workspace | None:
    """A workspace in a; itself for None, from straight above."""
    if workspace is None or wRa is None:
        return workspace
    if isinstance(workspace, ObjectRegion):
        return ObjectsAlong(workspace, wRa)
    return WorkspaceAlong(workspace, wRa)
