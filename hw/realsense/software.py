"""A camera of the vendor's library that is fed by an emulated one, over a socket.

Everything behind it is the vendor's: pipeline, profiles, filters. In its place a real camera has
its firmware and the cable.
"""

from __future__ import annotations

import socket
import threading
from contextlib import suppress
from typing import Any

import numpy as np

from hw.realsense.wire import HEAD, RESET, GoneError, Introduction, hear_introduction, receive

_PATIENCE = 3.0
"""For the connection and the first line [s]."""


class SoftwareCamera:
    """Connects to an emulated camera; feeds from `start` on.

    Args:
        library: of the vendor.
        address: HOST:PORT of the emulated camera.

    Raises:
        GoneError: nothing answers there.
    """

    def __init__(self, library: Any, address: str) -> None:
        self._library = library
        host, _, port = address.rpartition(":")
        try:
            self._socket = socket.create_connection((host, int(port)), _PATIENCE)
        except (OSError, ValueError, OverflowError) as error:
            why = getattr(error, "strerror", None) or str(error)
            raise GoneError(f"no emulated camera answers at {address}: {why}") from error
        try:
            self.introduction = hear_introduction(self._socket)
            self._socket.settimeout(None)
            self._build(self.introduction)
        except BaseException:
            self._socket.close()
            raise
        self.lost = ""
        """Why no more images come; empty while they may."""

    def start(self) -> None:
        """Begin to feed."""
        threading.Thread(target=self._feed, name="software camera", daemon=True).start()

    def reset(self) -> None:
        """Have the emulated camera start anew."""
        with suppress(OSError):
            self._socket.sendall(RESET)

    def close(self) -> None:
        """Let go of the emulated camera."""
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()

    def _build(self, told: Introduction) -> None:
        rs = self._library
        self.device = rs.software_device()
        self.device.register_info(rs.camera_info.name, told.name)
        self.device.register_info(rs.camera_info.serial_number, told.serial)
        for info, text in (
            (rs.camera_info.firmware_version, told.firmware),
            (rs.camera_info.recommended_firmware_version, told.recommended),
        ):
            if text:
                self.device.register_info(info, text)
        self._sensor = self.device.add_sensor("Stereo Module")
        self._depth = self._sensor.add_video_stream(
            self._stream(told, rs.stream.depth, 0, rs.format.z16, 2)
        )
        self._infrared = self._sensor.add_video_stream(
            self._stream(told, rs.stream.infrared, 1, rs.format.y8, 1)
        )
        self._sensor.add_read_only_option(rs.option.depth_units, told.depth_units)
        self._sensor.add_read_only_option(rs.option.stereo_baseline, 1e3 * told.baseline)

    def _stream(self, told: Introduction, kind: Any, index: int, form: Any, bpp: int) -> Any:
        rs = self._library
        intrinsics = rs.intrinsics()
        intrinsics.width, intrinsics.height = told.width, told.height
        intrinsics.fx, intrinsics.fy = told.fx, told.fy
        intrinsics.ppx, intrinsics.ppy = told.cx, told.cy
        intrinsics.model, intrinsics.coeffs = rs.distortion.brown_conrady, [0.0] * 5
        stream = rs.video_stream()
        stream.type, stream.index, stream.uid = kind, index, index
        stream.width, stream.height, stream.fps = told.width, told.height, told.rate
        stream.bpp, stream.fmt, stream.intrinsics = bpp, form, intrinsics
        return stream

    def _feed(self) -> None:
        size = (self.introduction.height, self.introduction.width)
        try:
            while True:
                number, captured, depth, infrared = HEAD.unpack(receive(self._socket, HEAD.size))
                for profile, kind, count in (
                    (self._infrared, np.uint8, infrared),  # first: depth completes the set
                    (self._depth, np.uint16, depth),
                ):
                    if count != (size[0] * size[1] * np.dtype(kind).itemsize if count else 0):
                        raise GoneError("the emulated camera sends images of another size")
                    if count:
                        pixels = np.frombuffer(receive(self._socket, count), kind).reshape(size)
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
