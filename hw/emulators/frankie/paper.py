"""A printed picture in the emulated world, as an infrared imager sees it: to calibrate by."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from robots import Intrinsics

Grey = npt.NDArray[np.uint8]

_PIXELS = 480
"""To which the width of a picture is brought."""
_FINER = 3
"""How much larger an image is drawn before it is averaged down."""
_MARGIN = 1.0 / 14.0
"""White paper around the picture, of its width."""
_AWAY, _TURN = 0.42, 0.4
"""Where it is put before the camera [m], and how it is turned there [rad]."""
_BLACK, _WHITE, _GROUND = 40.0, 190.0, 100.0
"""Brightness of ink, of paper and of what is around, of 255."""
_BLUR, _NOISE = 0.7, 4.0
"""Standard deviations of the lens' blur [px] and of the noise, of 255."""


class Paper:
    """A picture on something flat that stays where it is.

    Args:
        path: of the picture.
        width: of the picture on the paper [m].
        wTc: camera that it is put before: straight, 0.42 m away.

    Raises:
        ValueError: there is no such picture.
    """

    def __init__(self, path: str, width: float, wTc: SE3) -> None:
        read = cv2.imread(path, cv2.IMREAD_GRAYSCALE) if Path(path).is_file() else None
        if read is None:
            raise ValueError(f"{path} is no picture")
        high = round(_PIXELS * read.shape[0] / read.shape[1])
        picture = cv2.resize(read, (_PIXELS, high), interpolation=cv2.INTER_AREA)
        self._margin = round(_MARGIN * _PIXELS)
        ink = np.pad(picture, self._margin, constant_values=255).astype(np.float32) / 255.0
        self._bright = _BLACK + (_WHITE - _BLACK) * ink
        self._metre = _PIXELS / width
        turn = np.array(
            [[np.cos(_TURN), -np.sin(_TURN), 0.0], [np.sin(_TURN), np.cos(_TURN), 0.0], [0, 0, 1.0]]
        )
        middle = np.array([width, width * high / _PIXELS, 0.0]) / 2.0
        self._wTm = wTc * SE3(turn, np.array([0.0, 0.0, _AWAY]) - turn @ middle)

    def seen(self, wTc: SE3, camera: Intrinsics, rng: np.random.Generator) -> Grey:
        """(H, W) brightness of an image of it.

        Args:
            wTc: where the camera is.
            camera: its pinhole model.
            rng: of the noise.
        """
        cTm = wTc.actInv(self._wTm)
        offset = (0.5 - self._margin) / self._metre
        scale = 1.0 / self._metre
        to_paper = np.array([[scale, 0.0, offset], [0.0, scale, offset], [0.0, 0.0, 1.0]])
        plane = np.column_stack([cTm.rotation[:, 0], cTm.rotation[:, 1], cTm.translation])
        pinhole = np.array(
            [[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]]
        )
        shift = 0.5 * _FINER - 0.5
        finer = np.array([[_FINER, 0.0, shift], [0.0, _FINER, shift], [0.0, 0.0, 1.0]])
        drawn = cv2.warpPerspective(
            self._bright,
            finer @ pinhole @ plane @ to_paper,
            (camera.width * _FINER, camera.height * _FINER),
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=_GROUND,
        )
        image = cv2.resize(drawn, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
        blurred = cv2.GaussianBlur(image, (0, 0), _BLUR)
        noisy = blurred + _NOISE * rng.standard_normal(blurred.shape)
        grey: Grey = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
        return grey
