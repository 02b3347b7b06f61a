"""The input of perception, as protocols, so that a frame of any camera can be used."""

from typing import Protocol, TypeAlias, runtime_checkable

import numpy as np
import numpy.typing as npt

from config.arrays import Array, Image, Mask
from config.poses import OdometryPose
from perception.cloud import DepthCloud
from robots import Intrinsics

Colours: TypeAlias = npt.NDArray[np.uint8]


class Frame(Protocol):
    """A depth image with the camera's model and pose; `hw.DepthFrame` is one."""

    @property
    def depth(self) -> Image:
        """(H, W) depth along the optical axis [m]; NaN where missing."""

    @property
    def intrinsics(self) -> Intrinsics:
        """The camera's pinhole model."""

    @property
    def oTc(self) -> OdometryPose:
        """Camera in odometry at capture; z along the optical axis, x right, y down."""

    @property
    def stamp(self) -> float:
        """Time of capture [s]."""

    @property
    def cloud(self) -> DepthCloud:
        """Its points, each computed once for all who ask."""


class ColourFrame(Frame, Protocol):
    """A frame of a camera that may have colour; `hw.DepthFrame` is one."""

    @property
    def colour(self) -> Colours | None:
        """(H, W, 3) red, green and blue, 0 to 255."""


class Workspace(Protocol):
    """A volume in which to grasp; `behaviours.Region` is one."""

    def contains(self, points: Array) -> Mask:
        """(N,) which of the (N, 3) points in odometry [m] lie inside."""

    @property
    def floor(self) -> float:
        """Height of the support surface in odometry [m]."""


@runtime_checkable
class ObjectRegion(Workspace, Protocol):
    """A workspace made of segmented objects: only a grasp on one of them counts."""

    def owns(self, centres: Array, contacts: Array, pads: Array) -> Mask:
        """(N,) which grasps are on one of the objects and touch nothing else.

        `centres` (N, 3), `contacts` (N, 2, 3) and the ends of both `pads` (N, 4, 3) are in the
        world [m].
        """
