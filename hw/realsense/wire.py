"""The bytes between an emulated camera and the driver: ours, where a real camera has its cable.

The camera begins with one line of JSON that says what it is. Then come images: a head, depth of 16
bits a pixel, and where it has it the infrared image of 8 bits a pixel. The driver sends nothing but
a byte that resets the camera.
"""

from __future__ import annotations

import json
import socket
import struct
from dataclasses import asdict, dataclass

HEAD = struct.Struct("<QdII")
"""Number of the image, calendar time of its capture [s], bytes of depth, of infrared."""
RESET = b"R"
_LONGEST = 4096
"""A longer first line is none of ours [bytes]."""


class GoneError(Exception):
    """The other side has gone."""


@dataclass(frozen=True, kw_only=True)
class Introduction:
    """What an emulated camera is."""

    name: str
    serial: str
    width: int
    height: int
    rate: int
    fx: float
    fy: float
    cx: float
    cy: float
    depth_units: float
    """What 1 in a depth image is [m]."""
    baseline: float
    """Between its imagers; the vendor's filters work on disparities [m]."""
    infrared: bool
    """Whether there are infrared images, too."""
    firmware: str = ""
    recommended: str = ""
    """Firmware that the vendor's library is made for."""

    def line(self) -> bytes:
        """As it is sent."""
        return json.dumps(asdict(self)).encode() + b"\n"


def hear_introduction(connection: socket.socket) -> Introduction:
    """What the camera says first.

    Raises:
        GoneError: it says nothing, or something else.
    """
    line = b""
    while not line.endswith(b"\n"):
        if len(line) > _LONGEST:
            raise GoneError("what answers there is no emulated camera")
        line += receive(connection, 1)
    try:
        return Introduction(**json.loads(line))
    except (ValueError, TypeError) as error:
        raise GoneError("what answers there is no emulated camera") from error


def receive(connection: socket.socket, count: int) -> bytearray:
    """So many bytes.

    Raises:
        GoneError: they do not come.
    """
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
