"""What a wrist camera sees."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from robots import Intrinsics

DepthArray = npt.NDArray[np.float32]
ColourArray = npt.NDArray[np.uint8]
Paint: TypeAlias = Callable[[], ColourArray]
"""Makes the colours of a picture, once somebody asks for them."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DepthImage:
    """One image as a camera delivers it; the same object is the same image."""

    depth: DepthArray
    """(H, W) depth along the optical axis [m]; NaN where missing."""
    stamp: float
    """When it was captured, on the session's clock [s]."""
    paint: Paint | None = None
    """Makes its colours; None if the camera has none."""


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
    paint: Paint | None = None
    """Makes its colours; None if the camera has none."""

    @cached_property
    def colour(self) -> ColourArray | None:
        """(H, W, 3) red, green and blue of the same pixels, of 255; None if there are none."""
        return None if self.paint is None else self.paint()
