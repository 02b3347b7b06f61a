"""What a camera sees of the board, with the blur and noise of an infrared imager."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pinocchio import SE3

from hw.sim import photograph
from lab.calibration.board import Board, Grey
from robots import Intrinsics

_PIXELS = 60  # of a square in the picture of the board
_GROUND = 0.4  # brightness of what is around it, between ink and paper


@dataclass(frozen=True, kw_only=True)
class Look:
    """How the board looks to the imager."""

    blur: float = 0.7  # standard deviation of the lens' blur [px]
    noise: float = 4.0  # standard deviation of the noise, of 255
    black: float = 40.0  # brightness of the ink, of 255
    white: float = 190.0  # brightness of the paper, of 255
    shade: float = 0.25  # by how much the light falls off from one edge of the image to the other


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
    printed = board.picture(_PIXELS).astype(np.float32) / 255.0
    paper = np.pad(printed, _PIXELS // 2, constant_values=1.0)
    edge = -0.5 * board.square
    return photograph(
        np.float32(look.black) + np.float32(look.white - look.black) * paper,
        board.square / _PIXELS,
        cTm * SE3(np.eye(3), np.array([edge, edge, 0.0])),
        camera,
        rng,
        ground=look.black + (look.white - look.black) * _GROUND,
        blur=look.blur,
        noise=look.noise,
        shade=look.shade,
    )
