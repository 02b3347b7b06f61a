"""The frames of ArNetworking, and the stream of bytes that they arrive in.

A frame: 0x0F 0x0C, its length and its command as little-endian 16-bit numbers, the payload, and a
big-endian checksum [verified with a reference server]. TCP may split and join frames in any way.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

_SYNC = b"\x0f\x0c"
_HEADER, _TRAILER = 6, 2
_SHORTEST, _LONGEST = _HEADER + _TRAILER, 32000


class Packet(NamedTuple):
    """One message: a command below 256, or the number of a named request, and its payload."""

    command: int
    payload: bytes


def checksum(frame: bytes) -> int:
    """Of a whole frame, whose last two bytes do not matter.

    The sum of big-endian words begins in the middle of the length; what is left of it is one byte,
    which is added exclusively. In a frame of odd length the last byte of the payload is not
    covered.
    """
    covered = frame[3 : len(frame) - _TRAILER - len(frame) % 2]
    words = covered[:-1]
    total = sum(struct.unpack(f">{len(words) // 2}H", words)) & 0xFFFF
    return int(total ^ covered[-1])


def encode(command: int, payload: bytes = b"") -> bytes:
    """The frame of a message.

    Raises:
        ValueError: the payload is too long for one frame.
    """
    length = _HEADER + len(payload) + _TRAILER
    if length > _LONGEST:
        raise ValueError(f"a frame of {length} bytes; at most {_LONGEST} are allowed")
    body = _SYNC + struct.pack("<HH", length, command) + payload
    return body + struct.pack(">H", checksum(body + bytes(_TRAILER)))


class PacketStream:
    """Finds the frames in a stream of bytes; what is damaged is skipped."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self.skipped = 0
        """Bytes that belonged to no sound frame."""

    def feed(self, data: bytes) -> list[Packet]:
        """The messages that are complete with these bytes."""
        self._buffer += data
        packets = []
        while frame := self._next_frame():
            command = struct.unpack_from("<H", frame, 4)[0]
            packets.append(Packet(command, frame[_HEADER:-_TRAILER]))
        return packets

    def _next_frame(self) -> bytes:
        """Take the next sound frame out of the buffer; empty where it is not complete yet."""
        buffer = self._buffer
        while True:
            start = buffer.find(_SYNC)
            if start < 0:  # the first byte of a frame may have come alone
                start = len(buffer) - buffer.endswith(_SYNC[:1])
            self._skip(start)
            if len(buffer) < 4:
                return b""
            length = struct.unpack_from("<H", buffer, 2)[0]
            if not _SHORTEST <= length <= _LONGEST:
                self._skip(len(_SYNC))
                continue
            if len(buffer) < length:
                return b""
            frame = bytes(buffer[:length])
            if checksum(frame) == struct.unpack(">H", frame[-_TRAILER:])[0]:
                del buffer[:length]
                return frame
            self._skip(len(_SYNC))  # a sound frame may begin inside the damaged one

    def _skip(self, count: int) -> None:
        del self._buffer[:count]
        self.skipped += count
