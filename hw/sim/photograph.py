"""A flat picture as an infrared imager sees it."""

from __future__ import annotations

from typing import TypeAlias

import cv2
import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from robots import Intrinsics

Grey: TypeAlias = npt.NDArray[np.uint8]

_FINER = 4  # How much larger an image is drawn before it is averaged down


def photograph(
    picture: npt.NDArray[np.float32],
    pixel: float,
    cTp: SE3,
    camera: Intrinsics,
    rng: np.random.Generator,
    *,
    ground: float,
    blur: float,
    noise: float,
    shade: float = 0.0,
) -> Grey:
    """(H, W) brightness of an image of it.

    Args:
        picture: (h, w) brightness, of 255.
        pixel: edge of one of its pixels [m].
        cTp: the picture before the camera; its origin is the outer corner of the first pixel, x
            along the columns, y along the rows.
        camera: its pinhole model.
        rng: source of the noise.
        ground: brightness of what is around the picture, of 255.
        blur: standard deviation of the lens' blur [px].
        noise: standard deviation of the noise, of 255.
        shade: by how much the light falls off from one edge of the image to the other.
    """
    # The centre of a pixel has its number.
    to_plane = np.array([[pixel, 0.0, 0.5 * pixel], [0.0, pixel, 0.5 * pixel], [0.0, 0.0, 1.0]])
    plane = np.column_stack([cTp.rotation[:, :2], cTp.translation])
    shift = 0.5 * _FINER - 0.5
    finer = np.array([[_FINER, 0.0, shift], [0.0, _FINER, shift], [0.0, 0.0, 1.0]])
    drawn = cv2.warpPerspective(
        picture,
        finer @ camera.matrix @ plane @ to_plane,
        (camera.width * _FINER, camera.height * _FINER),
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=ground,
    )
    image = cv2.resize(drawn, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
    if blur > 0.0:
        image = cv2.GaussianBlur(image, (0, 0), blur)
    lit = image * (1.0 - shade * np.linspace(0.0, 1.0, camera.width))
    noisy = lit + noise * rng.standard_normal(lit.shape)
    grey: Grey = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
    return grey
