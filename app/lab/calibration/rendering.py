"""What a camera sees of the board, with the blur and noise of an infrared imager."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from pinocchio import SE3

from app.lab.calibration.board import Board, Grey, matrix
from robots import Intrinsics

_FINER = 4
"""How much larger an image is drawn before it is averaged down."""
_PIXELS = 60
"""Of a square in the picture of the board."""


@dataclass(frozen=True, kw_only=True)
class Look:
    """How the board looks to the imager."""

    blur: float = 0.7
    """Standard deviation of the lens' blur [px]."""
    noise: float = 4.0
    """Standard deviation of the noise, of 255."""
    black: float = 40.0
    """Brightness of the ink, of 255."""
    white: float = 190.0
    """Brightness of the paper, of 255."""
    shade: float = 0.25
    """By how much the light falls off from one edge of the image to the other."""


def render(
    board: Board, cTm: SE3, camera: Intrinsics, look: Look, rng: np.random.Generator
) -> Grey:
    """(H, W) brightness of an image of the board on a grey ground.

    Args:
        board: what is seen.
        cTm: where it is before the camera.
        camera: its pinhole model.
        look: of the board and of the camera.
        rng: source of the noise.
    """
    print_ = board.picture(_PIXELS).astype(np.float32) / 255.0
    paper = np.pad(print_, _PIXELS // 2, constant_values=1.0)
    metre = _PIXELS / board.square
    # From pixels of the paper to metres on the board; the centre of a pixel has its number.
    offset = (0.5 - _PIXELS // 2) / metre
    to_board = np.array([[1.0 / metre, 0.0, offset], [0.0, 1.0 / metre, offset], [0.0, 0.0, 1.0]])
    plane = np.column_stack([cTm.rotation[:, 0], cTm.rotation[:, 1], cTm.translation])
    shift = 0.5 * _FINER - 0.5
    finer = np.array([[_FINER, 0.0, shift], [0.0, _FINER, shift], [0.0, 0.0, 1.0]])
    warp = finer @ matrix(camera) @ plane @ to_board
    size = (camera.width * _FINER, camera.height * _FINER)
    drawn = cv2.warpPerspective(
        paper, warp, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0.4
    )
    image = cv2.resize(drawn, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
    if look.blur > 0.0:
        image = cv2.GaussianBlur(image, (0, 0), look.blur)
    light = 1.0 - look.shade * np.linspace(0.0, 1.0, camera.width)
    bright = (look.black + (look.white - look.black) * image) * light
    noisy = bright + look.noise * rng.standard_normal(bright.shape)
    grey: Grey = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
    return grey
