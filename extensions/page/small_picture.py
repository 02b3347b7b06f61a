"""Small JPEGs of the wrist camera's images, with the grasps that were found."""

from base64 import b64encode

import cv2
import numpy as np
import numpy.typing as npt

from app.live import grasp_outline, grey_range, millimetres
from config.arrays import Image
from hw import DepthFrame
from perception import Detection

_WIDEST = 480  # [px]
_MOST_GRASPS = 4
_BEST, _OTHERS = (80, 220, 80), (160, 160, 160)  # blue, green, red
_QUALITY = (cv2.IMWRITE_JPEG_QUALITY, 75)


def picture(frame: DepthFrame, detection: Detection | None) -> str:
    """A data URL of the colours, or else of the depth in grey, near white; the best grasp green."""
    image = _grey(frame.depth) if frame.colour is None else frame.colour[:, :, ::-1]
    scale = min(1.0, _WIDEST / image.shape[1])
    image = cv2.resize(np.ascontiguousarray(image), None, fx=scale, fy=scale).astype(np.uint8)
    grasps = detection.grasps[:_MOST_GRASPS] if detection else ()
    for grasp in reversed(grasps):  # the best on top
        outline = np.rint(16.0 * scale * grasp_outline(grasp, frame)).astype(np.int32)
        colour = _BEST if grasp is grasps[0] else _OTHERS
        cv2.polylines(image, [outline], True, colour, 2, cv2.LINE_AA, 4)
    return _data_url(image)


def depth_picture(depth: Image) -> str:
    """A data URL of a depth image (H, W) [m] in grey, near white."""
    return _data_url(_grey(depth))


def _data_url(image: npt.NDArray[np.uint8]) -> str:
    _, jpeg = cv2.imencode(".jpg", image, _QUALITY)
    return f"data:image/jpeg;base64,{b64encode(jpeg.tobytes()).decode()}"


def _grey(metres: Image) -> npt.NDArray[np.uint8]:
    depth = millimetres(metres)
    near, far = grey_range(depth)
    grey = np.clip(255.0 * (far - depth) / (far - near), 0.0, 255.0).astype(np.uint8)
    grey[depth == 0] = 0
    return np.repeat(grey[:, :, None], 3, axis=2)
