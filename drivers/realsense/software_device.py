"""A software device of the vendor's library that is fed by an emulated camera over a socket.

Pipeline, profiles and frames behind it are the vendor's; the socket stands for firmware and cable.
The emulated camera begins with one line of JSON, its introduction. Then come images: a head, the
infrared image of 8 bits a pixel where there is one, and depth of 16 bits a pixel, little-endian.
The driver sends nothing but a byte that resets the camera.
"""

import json
import socket
import struct
import threading
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

_PATIENCE = 3.0  # for the connection and the introduction [s]
HEAD = struct.Struct("<QdII")  # number, calendar time [s], bytes of depth and of infrared
RESET = b"R"
_LONGEST = 4096  # longest introduction [bytes]


class GoneError(Exception):
    """The emulated camera does not answer."""


@dataclass(frozen=True, kw_only=True)
class Introduction:
    """Properties of an emulated camera."""

    name: str
    serial: str
    width: int
    height: int
    rate: int
    fx: float
    fy: float
    cx: float
    cy: float
    depth_units: float  # one unit of a depth image [m]
    baseline: float  # between the imagers [m]
    infrared: bool  # whether there are infrared images
    firmware: str = ""
    recommended: str = ""  # firmware that the library recommends

    def line(self) -> bytes:
        """The line of JSON."""
        return json.dumps(asdict(self)).encode() + b"\n"


class SoftwareCamera:
    """Connects to an emulated camera at HOST:PORT; feeds the software device from `start` on."""

    def __init__(self, library: Any, address: str) -> None:
        self._library = library
        host, _, port = address.rpartition(":")
        try:
            self._socket = socket.create_connection((host, int(port)), _PATIENCE)
        except (OSError, ValueError, OverflowError) as error:
            why = getattr(error, "strerror", None) or str(error)
            raise GoneError(f"no emulated camera answers at {address}: {why}") from error
        try:
            self.introduction = _introduction(self._socket)
            self._socket.settimeout(None)
            self._build(self.introduction)
        except BaseException:
            self._socket.close()
            raise
        self.lost = ""  # why no more images come; empty while connected

    def start(self) -> None:
        """Begin to feed frames."""
        threading.Thread(target=self._feed, name="software camera", daemon=True).start()

    def reset(self) -> None:
        """Restart the emulated camera."""
        with suppress(OSError):
            self._socket.sendall(RESET)

    def close(self) -> None:
        """Close the connection."""
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()

    def _build(self, camera: Introduction) -> None:
        rs = self._library
        self.device = rs.software_device()
        self.device.register_info(rs.camera_info.name, camera.name)
        self.device.register_info(rs.camera_info.serial_number, camera.serial)
        for info, text in (
            (rs.camera_info.firmware_version, camera.firmware),
            (rs.camera_info.recommended_firmware_version, camera.recommended),
        ):
            if text:
                self.device.register_info(info, text)
        self._sensor = self.device.add_sensor("Stereo Module")
        self._depth = self._sensor.add_video_stream(
            self._stream(camera, rs.stream.depth, 0, rs.format.z16, 2)
        )
        self._infrared = self._sensor.add_video_stream(
            self._stream(camera, rs.stream.infrared, 1, rs.format.y8, 1)
        )
        self._sensor.add_read_only_option(rs.option.depth_units, camera.depth_units)
        self._sensor.add_read_only_option(rs.option.stereo_baseline, 1e3 * camera.baseline)

    def _stream(self, camera: Introduction, kind: Any, index: int, form: Any, bpp: int) -> Any:
        rs = self._library
        intrinsics = rs.intrinsics()
        intrinsics.width, intrinsics.height = camera.width, camera.height
        intrinsics.fx, intrinsics.fy = camera.fx, camera.fy
        intrinsics.ppx, intrinsics.ppy = camera.cx, camera.cy
        intrinsics.model, intrinsics.coeffs = rs.distortion.brown_conrady, [0.0] * 5
        stream = rs.video_stream()
        stream.type, stream.index, stream.uid = kind, index, index
        stream.width, stream.height, stream.fps = camera.width, camera.height, camera.rate
        stream.bpp, stream.fmt, stream.intrinsics = bpp, form, intrinsics
        return stream

    def _feed(self) -> None:
        size = (self.introduction.height, self.introduction.width)
        try:
            while True:
                number, captured, depth, infrared = HEAD.unpack(_receive(self._socket, HEAD.size))
                for profile, kind, count in (
                    (self._infrared, np.uint8, infrared),  # first: depth completes the set
                    (self._depth, np.uint16, depth),
                ):
                    if count != (size[0] * size[1] * np.dtype(kind).itemsize if count else 0):
                        raise GoneError("the emulated camera sends images of another size")
                    if count:
                        pixels = np.frombuffer(_receive(self._socket, count), kind).reshape(size)
                        self._give(profile, pixels, number, captured)
        except GoneError as error:
            self.lost = str(error)

    def _give(self, profile: Any, pixels: Any, number: int, captured: float) -> None:
        rs = self._library
        frame = rs.software_video_frame()
        frame.pixels, frame.bpp, frame.stride = pixels, pixels.itemsize, pixels.strides[0]
        frame.timestamp, frame.domain = captured * 1e3, rs.timestamp_domain.system_time
        frame.frame_number, frame.profile = number, profile.as_video_stream_profile()
        if profile is self._depth:
            frame.depth_units = self.introduction.depth_units
        self._sensor.on_video_frame(frame)


def _introduction(connection: socket.socket) -> Introduction:
    line = b""
    while not line.endswith(b"\n"):
        if len(line) > _LONGEST:
            raise GoneError("what answers there is no emulated camera")
        line += _receive(connection, 1)
    try:
        return Introduction(**json.loads(line))
    except (ValueError, TypeError) as error:
        raise GoneError("what answers there is no emulated camera") from error


def _receive(connection: socket.socket, count: int) -> bytearray:
    data = bytearray(count)
    view, have = memoryview(data), 0
    while have < count:
        try:
            got = connection.recv_into(view[have:])
        except OSError as error:
            raise GoneError("the emulated camera does not answer") from error
        if got == 0:
            raise GoneError("the emulated camera was unplugged")
        have += got
    return data
