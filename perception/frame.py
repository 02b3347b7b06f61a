"""The input of perception, as protocols, so that a frame of any camera can be used."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from robots import Intrinsics


class Frame(Protocol):
    """A depth image with the camera's model and pose; `hw.DepthFrame` is one."""

    @property
    def depth(self) -> npt.NDArray[np.float32]:
        """(H, W) depth along the optical axis [m]; NaN where missing."""

    @property
    def intrinsics(self) -> Intrinsics:
        """The camera's pinhole model."""

    @property
    def wTc(self) -> SE3:
        """Camera in the world at capture; z along the optical axis, x right, y down."""

    @property
    def stamp(self) -> float:
        """When it was captured [s]."""


class Workspace(Protocol):
    """A volume in which to grasp; `behaviours.Region` is one."""

    def contains(self, points: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        """Which of the (N, 3) world points [m] lie inside: (N,) booleans."""

    @property
    def floor(self) -> float:
        """Height of the support surface in the world [m]."""


@runtime_checkable
class Things(Workspace, Protocol):
    """A workspace made of things that were told apart: only a grasp on one of them counts."""

    def owns(
        self, centres: npt.NDArray[np.float64], contacts: npt.NDArray[np.float64]
    ) -> npt.NDArray[np.bool_]:
        """Which grasps are on one of them, and close on nothing else: (N,) booleans.

        Args:
            centres: (N, 3) in the world [m].
            contacts: (N, 2, 3) of both fingers, in the world [m].
        """
