"""The input of perception, as protocols, so that a frame of any camera can be used."""

from typing import Protocol, TypeAlias, runtime_checkable

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from robots import Intrinsics

Array: TypeAlias = npt.NDArray[np.float64]  # geometry in double precision
Image: TypeAlias = npt.NDArray[np.float32]  # depth, heights and network maps in single precision
FloatArray: TypeAlias = npt.NDArray[np.floating]
Mask: TypeAlias = npt.NDArray[np.bool_]
Indices: TypeAlias = npt.NDArray[np.int64]
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
    def wTc(self) -> SE3:
        """Camera in the world at capture; z along the optical axis, x right, y down."""

    @property
    def stamp(self) -> float:
        """Time of capture [s]."""


class ColourFrame(Frame, Protocol):
    """A frame of a camera that may have colour; `hw.DepthFrame` is one."""

    @property
    def colour(self) -> Colours | None:
        """(H, W, 3) red, green and blue, 0 to 255."""


class Workspace(Protocol):
    """A volume in which to grasp; `behaviours.Region` is one."""

    def contains(self, points: Array) -> Mask:
        """(N,) which of the (N, 3) world points [m] lie inside."""

    @property
    def floor(self) -> float:
        """Height of the support surface in the world [m]."""


@runtime_checkable
class ObjectRegion(Workspace, Protocol):
    """A workspace made of segmented objects: only a grasp on one of them counts."""

    def owns(self, centres: Array, contacts: Array, pads: Array) -> Mask:
        """(N,) which grasps are on one of the objects and touch nothing else.

        `centres` (N, 3), `contacts` (N, 2, 3) and the ends of both `pads` (N, 4, 3) are in the
        world [m].
        """
