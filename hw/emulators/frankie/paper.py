"""A printed picture in infrared images of the emulated camera, for calibration."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from pinocchio import SE3

from hw.sim import Grey, photograph
from robots import Intrinsics

_PIXELS = 480  # width to which pictures are scaled
_MARGIN = 1.0 / 14.0  # white margin, as a fraction of the width
_AWAY, _TURN = 0.42, 0.4  # distance from the camera [m] and rotation about its axis [rad]
_BLACK, _WHITE, _GROUND = 40.0, 190.0, 100.0  # brightness of ink, paper and background, of 255
_BLUR, _NOISE = 0.7, 4.0  # standard deviations of the lens' blur [px] and of the noise, of 255


class Paper:
    """A flat picture at a fixed pose, facing the camera.

    Args:
        path: of the picture.
        width: of the printed picture [m].
        wTc: camera pose in front of which it is put.

    Raises:
        ValueError: there is no such picture.
    """

    def __init__(self, path: str, width: float, wTc: SE3) -> None:
        read = cv2.imread(path, cv2.IMREAD_GRAYSCALE) if Path(path).is_file() else None
        if read is None:
            raise ValueError(f"{path} is no picture")
        high = round(_PIXELS * read.shape[0] / read.shape[1])
        picture = cv2.resize(read, (_PIXELS, high), interpolation=cv2.INTER_AREA)
        margin = round(_MARGIN * _PIXELS)
        ink = np.pad(picture, margin, constant_values=255).astype(np.float32) / 255.0
        self._bright = _BLACK + (_WHITE - _BLACK) * ink
        self._pixel = width / _PIXELS
        turn = np.array(
            [[np.cos(_TURN), -np.sin(_TURN), 0.0], [np.sin(_TURN), np.cos(_TURN), 0.0], [0, 0, 1.0]]
        )
        middle = np.array([width, width * high / _PIXELS, 0.0]) / 2.0
        wTm = wTc * SE3(turn, np.array([0.0, 0.0, _AWAY]) - turn @ middle)
        edge = -margin * self._pixel
        self._wTp = wTm * SE3(np.eye(3), np.array([edge, edge, 0.0]))

    def seen(self, wTc: SE3, camera: Intrinsics, rng: np.random.Generator) -> Grey:
        """(H, W) brightness, from a camera pose."""
        cTp = wTc.actInv(self._wTp)
        return photograph(
            self._bright, self._pixel, cTp, camera, rng, ground=_GROUND, blur=_BLUR, noise=_NOISE
        )
