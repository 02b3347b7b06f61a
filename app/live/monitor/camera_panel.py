"""Wrist camera in the recording: depth image, grasp quality over it, and detected grasps.

A picture that is out of date is drawn dark, without points and grasps.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt
import rerun as rr

from app.live.monitor.columns import WORLD, Array, Instant, send_poses, set_time
from app.live.monitor.glyphs import Colour
from app.live.monitor.scene_panel import gripper_outline
from app.live.snapshot import Snapshot
from hw import DepthFrame
from perception import Detection, GraspEstimate
from robots import Intrinsics

_CAMERA = "world/camera"
_IMAGE = "world/camera/image"
_WIDEST = 320
"""Most columns of a recorded image [px]."""
_LEVELS = 20
"""Steps of the heat map; step 0 is transparent."""

_BEST: Colour = (255, 255, 255)
_OTHERS: Colour = (150, 155, 165)
_MOST_GRASPS = 6
_FINGER_BREADTH = 0.02

STALE = 1.5
"""Age from which a picture is out of date [s]."""
_FADED = 0.35
_PNG = (cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_RLE)
_RUNNERS_UP = "world/runners_up"
_TRUE_ONLY = (f"{_CAMERA}/depth", f"{_CAMERA}/quality", f"{_CAMERA}/grasps", _RUNNERS_UP)
"""What is drawn of a picture only as long as it is true."""
_OLD = f"{_CAMERA}/old"


def millimetres(depth: npt.NDArray[np.float32]) -> npt.NDArray[np.uint16]:
    """(H, W) depth in millimetres from metres; 0 where missing."""
    whole = np.nan_to_num(depth * 1000.0, nan=0.0, posinf=0.0, neginf=0.0)
    image: npt.NDArray[np.uint16] = np.clip(np.rint(whole), 0, 65535).astype(np.uint16)
    return image


def heat_map(detection: Detection, width: int, height: int) -> npt.NDArray[np.uint8]:
    """(height, width) quality map over the full image, in steps from 0 to 1."""
    steps = np.clip(np.rint(detection.quality * _LEVELS), 0, _LEVELS).astype(np.uint8)
    u0, v0, size = detection.crop
    scale = size / steps.shape[1]
    # Centres of pixels are at whole numbers in both images.
    crop_to_image = np.array([[scale, 0.0, u0], [0.0, scale, v0]])
    over: npt.NDArray[np.uint8] = cv2.warpAffine(
        steps, crop_to_image, (width, height), flags=cv2.INTER_NEAREST
    ).astype(np.uint8)
    return over


def _grey_range(depth: npt.NDArray[np.uint16]) -> tuple[float, float]:
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


class CameraPanel:
    """Draws depth image, heat map and grasps at the time of capture."""

    def __init__(self, stream: rr.RecordingStream, lens: Intrinsics) -> None:
        self._stream = stream
        self._intrinsics: Intrinsics | None = None
        self._draw_camera(lens, -(-lens.width // _WIDEST))
        self._shown: tuple[float, npt.NDArray[np.uint16]] | None = None
        steps = np.arange(_LEVELS + 1)
        grey = (255 * steps / _LEVELS).astype(np.uint8)
        colours = cv2.applyColorMap(grey, cv2.COLORMAP_TURBO).reshape(-1, 3)[:, ::-1]
        classes = [
            rr.AnnotationInfo(
                id=step, label=f"quality {step / _LEVELS:.2f}", color=(*colour, 255 if step else 0)
            )
            for step, colour in zip(steps.tolist(), colours.tolist(), strict=True)
        ]
        for part in ("depth", "quality", "grasps", "old"):
            stream.log(f"{_CAMERA}/{part}", rr.CoordinateFrame(_IMAGE), static=True)
        stream.log(f"{_CAMERA}/quality", rr.AnnotationContext(classes), static=True)
        stream.log(
            f"{_CAMERA}/grasps",
            rr.LineStrips2D.from_fields(radii=rr.Radius.ui_points(1.5)),
            static=True,
        )
        stream.log(_RUNNERS_UP, rr.CoordinateFrame(WORLD), static=True)
        thin = rr.LineStrips3D.from_fields(colors=[_OTHERS], radii=rr.Radius.ui_points(1.0))
        stream.log(_RUNNERS_UP, thin, static=True)

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the frames of a batch."""
        for snapshot in batch:
            frame = snapshot.frame
            if frame is None:
                self._fade(snapshot)
            else:
                step = -(-frame.intrinsics.width // _WIDEST)
                captured = Instant(tick=snapshot.tick, stamp=frame.stamp)
                self._draw_camera(frame.intrinsics, step)
                send_poses(self._stream, [(captured, {_CAMERA: frame.wTc})])
                set_time(self._stream, captured)
                depth = millimetres(frame.depth[::step, ::step])
                if self._shown is None:
                    self._stream.log(_OLD, rr.Clear(recursive=False))
                self._shown = frame.stamp, depth
                self._draw_depth(depth)
                self._draw_detection(frame, snapshot.detection, step)

    def _fade(self, snapshot: Snapshot) -> None:
        """Darken an outdated picture, and remove its points and grasps."""
        if self._shown is None or snapshot.stamp - self._shown[0] < STALE:
            return
        _, depth = self._shown
        self._shown = None
        set_time(self._stream, snapshot)
        for path in _TRUE_ONLY:
            self._stream.log(path, rr.Clear(recursive=False))
        near, far = _grey_range(depth)
        grey = np.clip((depth - near) / (far - near), 0.0, 1.0) * (depth > 0)
        dark = np.ascontiguousarray((255.0 * _FADED * grey).astype(np.uint8))
        _, jpeg = cv2.imencode(".jpg", dark, [cv2.IMWRITE_JPEG_QUALITY, 60])
        self._stream.log(_OLD, rr.EncodedImage(contents=jpeg.tobytes(), media_type="image/jpeg"))

    def _draw_camera(self, camera: Intrinsics, step: int) -> None:
        """Log the pinhole model of the image that keeps every `step`th pixel."""
        if camera == self._intrinsics:
            return
        self._intrinsics = camera
        pinhole = rr.Pinhole(
            focal_length=(camera.fx / step, camera.fy / step),
            principal_point=(camera.cx / step, camera.cy / step),
            width=-(-camera.width // step),
            height=-(-camera.height // step),
            camera_xyz=rr.ViewCoordinates.RDF,
            image_plane_distance=0.12,
            parent_frame=_CAMERA,
            child_frame=_IMAGE,
        )
        self._stream.log(_CAMERA, pinhole, rr.CoordinateFrame(_IMAGE), static=True)

    def _draw_depth(self, depth: npt.NDArray[np.uint16]) -> None:
        _, png = cv2.imencode(".png", depth, _PNG)
        image = rr.EncodedDepthImage(
            png.tobytes(),
            media_type="image/png",
            meter=1000.0,
            colormap="grayscale",
            depth_range=_grey_range(depth),
        )
        self._stream.log(f"{_CAMERA}/depth", image)

    def _draw_detection(self, frame: DepthFrame, detection: Detection | None, step: int) -> None:
        height, width = frame.depth.shape
        steps = np.zeros((height, width), np.uint8)
        grasps: tuple[GraspEstimate, ...] = ()
        if detection is not None:
            steps = heat_map(detection, width, height)
            grasps = detection.grasps[:_MOST_GRASPS]
        heat = rr.SegmentationImage(np.ascontiguousarray(steps[::step, ::step]), opacity=0.55)
        self._stream.log(f"{_CAMERA}/quality", heat)
        outlines = rr.LineStrips2D.from_fields(
            strips=[grasp_outline(grasp, frame) / step for grasp in grasps],
            colors=[_BEST, *[_OTHERS] * len(grasps)][: len(grasps)],
        )
        self._stream.log(f"{_CAMERA}/grasps", outlines)
        others = [gripper_outline(grasp.wTg, grasp.width) for grasp in grasps[1:]]
        self._stream.log(_RUNNERS_UP, rr.LineStrips3D.from_fields(strips=others))
