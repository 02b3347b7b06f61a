"""The RealSense D435: depth images of the vendor's library, from a process of its own.

`camera` is the part of a robot, `camera_process` the process behind it: `stream` opens a camera, a
recording or an emulated one, `software` and `wire` are the last, `stamps` says when an image was
captured, `images` brings it to the description's intrinsics, `album` is the memory that both
processes share. docs/hardware.md says what of all this was verified, and what is inferred.
"""

from hw.realsense.camera import CameraReport, GreyImage, RealSenseCamera
from hw.realsense.library import missing
from hw.realsense.records import Status
from hw.realsense.settings import RealSenseSettings
from hw.realsense.wire import HEAD, RESET, Introduction

__all__ = [
    "HEAD",
    "RESET",
    "CameraReport",
    "GreyImage",
    "Introduction",
    "RealSenseCamera",
    "RealSenseSettings",
    "Status",
    "missing",
]
