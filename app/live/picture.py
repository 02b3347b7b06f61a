"""Images of the wrist camera: a small JPEG with the grasps that were found, and whole PNGs."""

from base64 import b64encode
from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from app.live.snapshot import Array
from hw import DepthFrame
from perception import Detection, GraspEstimate

_FINGER_BREADTH = 0.02  # [m]
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


def depth_picture(depth: npt.NDArray[np.float32]) -> str:
    """A data URL of a depth image (H, W) [m] in grey, near white."""
    return _data_url(_grey(depth))


def _data_url(image: npt.NDArray[np.uint8]) -> str:
    _, jpeg = cv2.imencode(".jpg", image, _QUALITY)
    return f"data:image/jpeg;base64,{b64encode(jpeg.tobytes()).decode()}"


def _grey(metres: npt.NDArray[np.float32]) -> npt.NDArray[np.uint8]:
    depth = millimetres(metres)
    near, far = grey_range(depth)
    grey = np.clip(255.0 * (far - depth) / (far - near), 0.0, 255.0).astype(np.uint8)
    grey[depth == 0] = 0
    return np.repeat(grey[:, :, None], 3, axis=2)


def colour_png(frames: Sequence[DepthFrame]) -> bytes:
    """The colours of frames that have them, as PNG."""
    return b"".join(_png(one.colour[:, :, ::-1]) for one in frames if one.colour is not None)


def depth_png(frames: Sequence[DepthFrame]) -> bytes:
    """The depth of frames in millimetres, as PNG of 16 bits."""
    return b"".join(_png(millimetres(one.depth)) for one in frames)


def _png(image: npt.NDArray[np.uint8] | npt.NDArray[np.uint16]) -> bytes:
    return cv2.imencode(".png", np.ascontiguousarray(image))[1].tobytes()


def millimetres(depth: npt.NDArray[np.float32]) -> npt.NDArray[np.uint16]:
    """(H, W) depth in millimetres from metres; 0 where missing."""
    whole = np.nan_to_num(depth * 1000.0, nan=0.0, posinf=0.0, neginf=0.0)
    image: npt.NDArray[np.uint16] = np.clip(np.rint(whole), 0, 65535).astype(np.uint16)
    return image


def grey_range(depth: npt.NDArray[np.uint16]) -> tuple[float, float]:
    """Depths drawn black and white [mm], for near objects rather than the floor behind them."""
    measured = depth[depth > 0]
    if not measured.size:
        return 0.0, 1000.0
    near, far = np.percentile(measured, (1, 40))
    return float(near), float(max(far, near + 150.0))


def grasp_outline(grasp: GraspEstimate, frame: DepthFrame) -> Array:
    """(5, 2) closed outline of the open fingers in the image [px]."""
    distance = max(float(frame.wTc.actInv(grasp.wTg.translation)[2]), 1e-3)
    scale = frame.intrinsics.fx / distance / 2.0
    across = scale * grasp.width * np.array([np.cos(grasp.angle), np.sin(grasp.angle)])
    along = scale * _FINGER_BREADTH * np.array([-np.sin(grasp.angle), np.cos(grasp.angle)])
    corners = [across + along, across - along, -across - along, -across + along, across + along]
    outline: Array = np.array(grasp.pixel) + np.array(corners)
    return outline
