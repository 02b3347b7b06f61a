"""A depth camera and a laser in ROS 2."""

from typing import Any

import numpy as np
import numpy.typing as npt
from pydantic import Field

from extensions.ros2.checked_messages import Lens, lens, scan, sized
from extensions.ros2.part import Ros2Options, Ros2Part
from hw import (
    DepthArray,
    DepthImage,
    DriverContext,
    Fault,
    HardwareError,
    LaserReading,
    RefusedError,
)
from robots import CameraDescription

_IMAGE, _SCAN = 1 << 23, 1 << 17  # longest messages [bytes]
_PNG = 12  # length of the header before compressed depth [bytes]
_TYPES = {"16UC1": "u2", "mono16": "u2", "32FC1": "f4"}  # by encoding


class CameraOptions(Ros2Options):
    """A depth camera: 16UC1 in millimetres or 32FC1 in metres, along the optical axis."""

    depth: str = "camera/depth/image_rect_raw"  # sensor_msgs/Image
    compressed: bool = False  # sensor_msgs/CompressedImage of `compressed_depth_image_transport`
    info: str = "camera/depth/camera_info"
    silence: float = Field(default=0.5, ge=0.05, le=2.0)


class Ros2Camera(Ros2Part):
    """A depth camera; images are brought to the intrinsics of the description."""

    _part = "camera"
    _needs = (1, 0)

    def __init__(self, options: CameraOptions, context: DriverContext) -> None:
        self._camera = context.robot.camera
        kind = f"sensor_msgs/msg/{'CompressedImage' if options.compressed else 'Image'}"
        routes = [
            options.hears(options.depth, kind, slots=3, size=_IMAGE),
            options.hears(options.info, "sensor_msgs/msg/CameraInfo"),
        ]
        super().__init__(options, context.clock, routes, {0: self._depth, 1: lens})
        self._lens: Lens | None = None
        self._maps: tuple[DepthArray, DepthArray] | None = None
        self._image: DepthImage | None = None

    def latest(self) -> DepthImage | None:
        """The newest image."""
        self._trouble()
        return self._image

    def faults(self) -> tuple[Fault, ...]:
        """A fault while no images come."""
        return self._faults()

    def _hear(self) -> None:
        for _, told in self._new(1):
            if self._lens is None or not told.is_like(self._lens):
                self._lens, self._maps = told, _maps(told, self._camera)
        images = list(self._new(0)) if self._lens is not None else []
        if images:
            stamp, depth = images[-1]
            self._image = DepthImage(depth=self._rectified(depth), stamp=stamp)

    def _depth(self, image: Any) -> DepthArray:
        """(H, W) of a message [m], of the size that the intrinsics are for."""
        assert self._lens is not None
        if hasattr(image, "width"):  # before its bytes are looked at
            sized(image.width, image.height, self._lens)
        depth = _metres(image)
        sized(depth.shape[1], depth.shape[0], self._lens)
        return depth

    def _rectified(self, depth: DepthArray) -> DepthArray:
        import cv2

        if self._maps is not None:
            x, y = self._maps
            depth = np.asarray(cv2.remap(depth, x, y, cv2.INTER_NEAREST, borderValue=float("nan")))
        bad = ~((depth >= self._camera.min_range) & (depth <= self._camera.max_range))
        depth[bad] = np.nan
        return depth


def _metres(image: Any) -> DepthArray:
    pixels = depth_of(image)
    if pixels is None:
        form = image.format if hasattr(image, "format") else image.encoding
        if "compressedDepth" in form:
            raise RefusedError("data", f"{len(image.data)} bytes", "no PNG of 16 bits")
        raise RefusedError("encoding", f"`{form}`", "not 16UC1 or 32FC1, compressed as PNG")
    unit = 1e-3 if pixels.dtype.kind == "u" else 1.0
    return np.asarray(pixels * np.float32(unit), np.float32)


def depth_of(image: Any) -> npt.NDArray[Any] | None:
    """(H, W) depth of an Image or CompressedImage: whole numbers are millimetres, others metres.

    None: it is no depth, which is 16UC1 or 32FC1 (REP 118). RefusedError: bytes are missing.
    """
    if (form := getattr(image, "format", None)) is not None:
        return _compressed(image) if "compressedDepth" in form else None
    if (kind := _TYPES.get(image.encoding)) is None:
        return None
    number = np.dtype(kind).newbyteorder(">" if image.is_bigendian else "<")
    size = number.itemsize * image.width
    if len(image.data) != image.height * image.step or image.step < size:
        size = f"{image.width} x {image.height}, {image.step} bytes a row"
        raise RefusedError("data", f"{len(image.data)} bytes", f"not those of {size}")
    rows = np.frombuffer(image.data, np.uint8).reshape(image.height, image.step)
    return np.ascontiguousarray(rows[:, :size]).view(number)


def _compressed(image: Any) -> npt.NDArray[Any] | None:
    """The depth in a PNG, which of 32FC1 is the quantised inverse; None if that is no depth."""
    import cv2

    data = np.frombuffer(image.data, np.uint8)
    pixels = cv2.imdecode(data[_PNG:], cv2.IMREAD_UNCHANGED) if len(data) > _PNG else None
    if pixels is None or pixels.dtype != np.uint16:
        return None
    if not image.format.startswith("32FC1"):
        return pixels
    a, b = data[4:_PNG].view("<f4")
    with np.errstate(divide="ignore"):
        return np.where(pixels > 0, a / (pixels.astype(np.float32) - b), np.nan)


def _maps(own: Lens, camera: CameraDescription) -> tuple[DepthArray, DepthArray] | None:
    """Where the pixels of the description are in an image; None where they are its own."""
    K, ours = own.K, camera.intrinsics
    is_same = (own.width, own.height) == (ours.width, ours.height)
    if is_same and np.allclose(K, ours.matrix, atol=1e-3):
        return None
    v, u = np.mgrid[: ours.height, : ours.width].astype(np.float32)
    x = (u - ours.cx) / ours.fx * K[0, 0] + K[0, 2]
    y = (v - ours.cy) / ours.fy * K[1, 1] + K[1, 2]
    return x.astype(np.float32), y.astype(np.float32)


class LaserOptions(Ros2Options):
    """A laser."""

    scan: str = "scan"  # sensor_msgs/LaserScan
    silence: float = Field(default=0.5, ge=0.05, le=2.0)


class Ros2Laser(Ros2Part):
    """A laser where the description mounts it."""

    _part = "laser"

    def __init__(self, options: LaserOptions, context: DriverContext) -> None:
        routes = [options.hears(options.scan, "sensor_msgs/msg/LaserScan", size=_SCAN)]
        super().__init__(options, context.clock, routes, {0: scan})
        if context.robot.laser is None:
            raise HardwareError("the robot's description has no laser, which says where it is")
        self._bTs, self._reach = context.robot.laser.bTs, context.robot.laser.max_range
        self._reading: LaserReading | None = None

    def latest(self) -> LaserReading | None:
        """The newest scan."""
        self._trouble()
        return self._reading

    def _hear(self) -> None:
        for stamp, (angles, ranges) in self._new(0):
            rays = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(ranges))], axis=1)
            reached = np.minimum(ranges, self._reach)
            points = (reached[:, None] * rays) @ self._bTs.rotation.T + self._bTs.translation
            self._reading = LaserReading(stamp=stamp, ranges=ranges, points=points)
