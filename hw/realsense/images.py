"""From frames of the vendor's library to images of the description's camera, in metres."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from hw.realsense.album import Depth, Grey
from hw.realsense.settings import RealSenseSettings
from hw.realsense.stream import LostError

Map = npt.NDArray[np.float32]


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """The images that are wanted: pinhole model, and the depths that count."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    near: float
    """[m]"""
    far: float
    """[m]"""

    @property
    def matrix(self) -> npt.NDArray[np.float64]:
        """(3, 3) of the pinhole model [px]."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])


class Rectifier:
    """Brings images of one pinhole camera to another one at the same place.

    A camera has intrinsics of its own, which differ from one to the next. What follows knows one
    set, that of the description. The depth along the optical axis stays what it is.

    Args:
        told: intrinsics as the vendor's library tells them.
        wanted: those of the images that are wanted.

    Raises:
        LostError: the camera has a distortion, which depth streams of the D400 series have not.
    """

    def __init__(self, told: Any, wanted: Wanted) -> None:
        if any(told.coeffs):
            raise LostError(f"its depth images are distorted ({told.model}): not a D400 camera?")
        own = np.array([[told.fx, 0.0, told.ppx], [0.0, told.fy, told.ppy], [0.0, 0.0, 1.0]])
        size = (wanted.width, wanted.height)
        same = np.allclose(own, wanted.matrix, atol=1e-3) and size == (told.width, told.height)
        self._maps = None if same else _maps(own, wanted)

    def depth(self, image: npt.NDArray[np.uint16]) -> npt.NDArray[np.uint16]:
        """(H, W) depth, each pixel that of the nearest one; 0 beyond the edges."""
        nearest: npt.NDArray[np.uint16] = self._brought(image, cv2.INTER_NEAREST)
        return nearest

    def grey(self, image: Grey) -> Grey:
        """(H, W) grey values, interpolated; 0 beyond the edges."""
        between: Grey = self._brought(image, cv2.INTER_LINEAR)
        return between

    def _brought(self, image: Any, interpolation: int) -> Any:
        if self._maps is None:
            return image
        return cv2.remap(image, *self._maps, interpolation, borderMode=cv2.BORDER_CONSTANT)


def _maps(own: npt.NDArray[np.float64], wanted: Wanted) -> tuple[Map, Map]:
    u = (np.arange(wanted.width) - wanted.cx) / wanted.fx * own[0, 0] + own[0, 2]
    v = (np.arange(wanted.height) - wanted.cy) / wanted.fy * own[1, 1] + own[1, 2]
    x, y = np.meshgrid(u.astype(np.float32), v.astype(np.float32))
    return x, y


class Filters:
    """The vendor's filters in the order that the vendor advises.

    Args:
        library: of the vendor.
        settings: which of them.
    """

    def __init__(self, library: Any, settings: RealSenseSettings) -> None:
        smooth = [library.spatial_filter()] if settings.spatial else []
        smooth += [library.temporal_filter()] if settings.temporal else []
        to_disparity = [library.disparity_transform(True)] if smooth else []
        to_depth = [library.disparity_transform(False)] if smooth else []
        self._filters = [*to_disparity, *smooth, *to_depth]

    def apply(self, frame: Any) -> Any:
        """A filtered depth frame."""
        for one in self._filters:
            frame = one.process(frame)
        return frame


def metres(depth: npt.NDArray[np.uint16], scale: float, wanted: Wanted) -> Depth:
    """Depth in metres; NaN where the camera has measured nothing, or nothing that counts.

    Args:
        depth: (H, W) in steps of the camera; 0 where it has measured nothing.
        scale: one step [m].
        wanted: which depths count.
    """
    far: Depth = depth * np.float32(scale)
    far[(far < np.float32(wanted.near)) | (far > np.float32(wanted.far))] = np.nan
    return far
