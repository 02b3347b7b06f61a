"""Wrist camera in the recording: depth image, grasp quality over it, and detected grasps.

They are removed once the picture is out of date.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import rerun as rr

from app.live.monitor.columns import Instant, log_static, send_poses, set_time
from app.live.monitor.glyphs import Colour
from app.live.picture import colour_png, depth_png, grasp_outline, grey_range, millimetres
from app.live.run_snapshot import Snapshot
from hw import DepthFrame
from perception import Detection, GraspEstimate
from robots import Intrinsics

STALE = 1.5  # age from which a picture is out of date [s]

_CAMERA = "world/camera"
_IMAGE = "world/camera/image"
_PARTS: Mapping[str, Any] = {
    f"{_CAMERA}/depth": rr.EncodedDepthImage,
    f"{_CAMERA}/quality": rr.SegmentationImage,
    f"{_CAMERA}/grasps": rr.LineStrips2D,
}
_DEPTH, _QUALITY, _GRASPS = _PARTS
_WIDEST = 320  # most columns of a recorded image [px]
_LEVELS = 20  # steps of the heat map; step 0 is transparent
_BEST: Colour = (255, 255, 255)
_OTHERS: Colour = (150, 155, 165)
_MOST_GRASPS = 6
_PNG = (cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_RLE)


class CameraPanel:
    """Draws depth image, heat map and grasps at the time of capture."""

    def __init__(self, stream: rr.RecordingStream, lens: Intrinsics) -> None:
        self._stream = stream
        self._intrinsics: Intrinsics | None = None
        self._draw_camera(lens)
        self._shown: float | None = None
        thin = rr.LineStrips2D.from_fields(radii=rr.Radius.ui_points(1.5))
        log_static(stream, {_DEPTH: (), _QUALITY: (_quality_colours(),), _GRASPS: (thin,)}, _IMAGE)

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the frames of a batch."""
        for snapshot in batch:
            frame = snapshot.frame
            for name, kept in snapshot.pictures:
                set_time(self._stream, snapshot)
                png = (depth_png if kept.paint is None else colour_png)([kept])
                image = rr.EncodedImage(contents=png, media_type="image/png")
                self._stream.log(["pictures", name], image)
            if frame is not None:
                captured = Instant(tick=snapshot.tick, stamp=frame.stamp)
                self._draw_camera(frame.intrinsics)
                send_poses(self._stream, [(captured, {_CAMERA: snapshot.mTo * frame.oTc})])
                set_time(self._stream, captured)
                self._draw(frame, snapshot.detection)
                self._shown = frame.stamp
            elif self._shown is not None and snapshot.stamp >= self._shown + STALE:
                self._shown = None
                set_time(self._stream, snapshot)
                for path, kind in _PARTS.items():  # after a `Clear` the viewer shows shadows
                    self._stream.log(path, kind.from_fields(clear_unset=True))

    def _draw_camera(self, camera: Intrinsics) -> None:
        """Log the pinhole model of the recorded image."""
        if camera == self._intrinsics:
            return
        self._intrinsics = camera
        step = _step(camera)
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

    def _draw(self, frame: DepthFrame, detection: Detection | None) -> None:
        step = _step(frame.intrinsics)
        depth = millimetres(frame.depth[::step, ::step])
        _, png = cv2.imencode(".png", depth, _PNG)
        image = rr.EncodedDepthImage(
            png.tobytes(),
            media_type="image/png",
            meter=1000.0,
            colormap="grayscale",
            depth_range=grey_range(depth),
        )
        height, width = frame.depth.shape
        steps = np.zeros((height, width), np.uint8)
        grasps: tuple[GraspEstimate, ...] = ()
        if detection is not None:
            steps = heat_map(detection, width, height)
            grasps = detection.grasps[:_MOST_GRASPS]
        heat = rr.SegmentationImage(np.ascontiguousarray(steps[::step, ::step]), opacity=0.55)
        outlines = rr.LineStrips2D.from_fields(
            strips=[grasp_outline(grasp, frame) / step for grasp in grasps],
            colors=[_BEST, *[_OTHERS] * len(grasps)][: len(grasps)],
        )
        for path, drawn in zip(_PARTS, (image, heat, outlines), strict=True):
            self._stream.log(path, drawn)


def _step(camera: Intrinsics) -> int:
    """Distance of the recorded pixels [px]."""
    return -(-camera.width // _WIDEST)


def _quality_colours() -> rr.AnnotationContext:
    steps = np.arange(_LEVELS + 1)
    grey = (255 * steps / _LEVELS).astype(np.uint8)
    colours = cv2.applyColorMap(grey, cv2.COLORMAP_TURBO).reshape(-1, 3)[:, ::-1]
    return rr.AnnotationContext(
        [
            rr.AnnotationInfo(
                id=step, label=f"quality {step / _LEVELS:.2f}", color=(*colour, 255 if step else 0)
            )
            for step, colour in zip(steps.tolist(), colours.tolist(), strict=True)
        ]
    )


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
