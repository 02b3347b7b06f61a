"""Rectification of depth and infrared images to the intrinsics of the robot description."""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from config.arrays import Array
from drivers.realsense.image_buffer import Grey, Image
from drivers.realsense.stream import LostError


@dataclass(frozen=True, kw_only=True)
class ImageSpec:
    """The images to deliver: pinhole model [px] and valid depth range [m]."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    near: float
    far: float

    @property
    def matrix(self) -> Array:
        """(3, 3) camera matrix [px]."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])


class Rectifier:
    """Maps images of a pinhole camera to another at the same place; LostError: it distorts."""

    def __init__(self, camera: Any, spec: ImageSpec) -> None:
        if any(camera.coeffs):
            raise LostError(f"its depth images are distorted ({camera.model}): not a D400 camera?")
        own = np.array([[camera.fx, 0.0, camera.ppx], [0.0, camera.fy, camera.ppy], [0, 0, 1.0]])
        size = (spec.width, spec.height)
        same = np.allclose(own, spec.matrix, atol=1e-3) and size == (camera.width, camera.height)
        self._maps = None if same else _maps(own, spec)

    def depth(self, image: npt.NDArray[np.uint16]) -> npt.NDArray[np.uint16]:
        """(H, W) depth by nearest neighbour; 0 beyond the edges."""
        nearest: npt.NDArray[np.uint16] = self._remap(image, cv2.INTER_NEAREST)
        return nearest

    def grey(self, image: Grey) -> Grey:
        """(H, W) grey values, interpolated; 0 beyond the edges."""
        linear: Grey = self._remap(image, cv2.INTER_LINEAR)
        return linear

    def _remap(self, image: Any, interpolation: int) -> Any:
        if self._maps is None:
            return image
        return cv2.remap(image, *self._maps, interpolation, borderMode=cv2.BORDER_CONSTANT)


def _maps(own: Array, spec: ImageSpec) -> tuple[Image, Image]:
    u = (np.arange(spec.width) - spec.cx) / spec.fx * own[0, 0] + own[0, 2]
    v = (np.arange(spec.height) - spec.cy) / spec.fy * own[1, 1] + own[1, 2]
    x, y = np.meshgrid(u.astype(np.float32), v.astype(np.float32))
    return x, y


def metres(depth: npt.NDArray[np.uint16], scale: float, spec: ImageSpec) -> Image:
    """Image in metres of (H, W) in units of `scale` [m]; NaN where missing or out of range."""
    far: Image = depth * np.float32(scale)
    far[(far < np.float32(spec.near)) | (far > np.float32(spec.far))] = np.nan
    return far
