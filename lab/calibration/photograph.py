"""Image of a flat picture in an infrared camera."""

import cv2
import numpy as np
from pinocchio import SE3

from config.arrays import Image
from lab.calibration.board import Grey
from robots import Intrinsics

_OVERSAMPLING = 4


def photograph(
    picture: Image,
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
    """(H, W) brightness of an image of a flat picture.

    `picture` is (h, w) brightness of 255 with pixels of an edge [m]; its frame begins at the
    outer corner of the first pixel, x along columns, y along rows. `ground` is the brightness
    around, `blur` that of the lens [px], `noise` a deviation, `shade` the loss of light towards
    one edge.
    """
    # The centre of a pixel has its number.
    to_plane = np.array([[pixel, 0.0, 0.5 * pixel], [0.0, pixel, 0.5 * pixel], [0.0, 0.0, 1.0]])
    plane = np.column_stack([cTp.rotation[:, :2], cTp.translation])
    shift = 0.5 * _OVERSAMPLING - 0.5
    finer = np.array([[_OVERSAMPLING, 0.0, shift], [0.0, _OVERSAMPLING, shift], [0.0, 0.0, 1.0]])
    drawn = cv2.warpPerspective(
        picture,
        finer @ camera.matrix @ plane @ to_plane,
        (camera.width * _OVERSAMPLING, camera.height * _OVERSAMPLING),
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
