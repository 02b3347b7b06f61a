"""What a wrist camera sees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from robots import Intrinsics

DepthArray = npt.NDArray[np.float32]


@dataclass(frozen=True, kw_only=True, eq=False)
class DepthImage:
    """One image as a camera delivers it; the same object is the same image."""

    depth: DepthArray
    """(H, W) depth along the optical axis [m]; NaN where missing."""
    stamp: float
    """When it was captured, on the session's clock [s]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DepthFrame:
    """One depth image and where it was taken from; the same object is the same frame."""

    depth: DepthArray
    """(H, W) depth along the optical axis [m]; NaN where missing."""
    intrinsics: Intrinsics
    wTc: SE3
    """Camera in the world at capture; z along the optical axis, x right, y down."""
    stamp: float
    """When it was captured, on the session's clock [s]."""
