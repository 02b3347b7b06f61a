"""Images of the wrist camera as PNG, and what is drawn on them."""

from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from config.arrays import Array, Image
from hw import DepthFrame
from perception import GraspEstimate

_FINGER_BREADTH = 0.02  # [m]


def colour_png(frames: Sequence[DepthFrame]) -> bytes:
    """The colours of frames that have them, as PNG."""
    return b"".join(_png(one.colour[:, :, ::-1]) for one in frames if one.colour is not None)


def depth_png(frames: Sequence[DepthFrame]) -> bytes:
    """The depth of frames in millimetres, as PNG of 16 bits."""
    return b"".join(_png(millimetres(one.depth)) for one in frames)


def _png(image: npt.NDArray[np.uint8] | npt.NDArray[np.uint16]) -> bytes:
    return cv2.imencode(".png", np.ascontiguousarray(image))[1].tobytes()


def millimetres(depth: Image) -> npt.NDArray[np.uint16]:
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
    distance = max(float(frame.oTc.actInv(grasp.oTg.translation)[2]), 1e-3)
    scale = frame.intrinsics.fx / distance / 2.0
    across = scale * grasp.width * np.array([np.cos(grasp.angle), np.sin(grasp.angle)])
    along = scale * _FINGER_BREADTH * np.array([-np.sin(grasp.angle), np.cos(grasp.angle)])
    corners = [across + along, across - along, -across - along, -across + along, across + along]
    outline: Array = np.array(grasp.pixel) + np.array(corners)
    return outline
