"""Wire format of ArNetworking: frames, and the fields of their payloads.

A frame is 0x0F 0x0C, its length and its command as little-endian 16-bit numbers, the payload, and a
big-endian checksum [verified with a reference server]. TCP may split and join frames in any way.
Fields are little-endian integers, text that ends with NUL, and numbers as text.
"""

import re
import struct
from math import inf
from typing import NamedTuple

_SYNC = b"\x0f\x0c"
_HEADER, _TRAILER = 6, 2
_SHORTEST, _LONGEST = _HEADER + _TRAILER, 32000
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d{1,3})?", re.IGNORECASE)


class LayoutError(ValueError):
    """A payload does not have the expected layout."""


class Packet(NamedTuple):
    """One message: a command below 256 or the number of a named request, and its payload."""

    command: int
    payload: bytes


def _checksum(frame: bytes) -> int:
    """Checksum of a whole frame, whose last two bytes do not matter.

    The sum of big-endian words begins in the middle of the length; a remaining byte is added
    exclusively. In a frame of odd length the last byte of the payload is not covered.
    """
    covered = frame[3 : len(frame) - _TRAILER - len(frame) % 2]
    words = covered[:-1]
    total = sum(struct.unpack(f">{len(words) // 2}H", words)) & 0xFFFF
    return int(total ^ covered[-1])


def encode(command: int, payload: bytes = b"") -> bytes:
    """The frame of a message."""
    length = _HEADER + len(payload) + _TRAILER
    if length > _LONGEST:
        raise ValueError(f"a frame of {length} bytes; at most {_LONGEST} are allowed")
    body = _SYNC + struct.pack("<HH", length, command) + payload
    return body + struct.pack(">H", _checksum(body + bytes(_TRAILER)))


class PacketStream:
    """Finds the frames in a stream of bytes; damaged ones are skipped."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self.skipped = 0  # bytes outside of valid frames

    def feed(self, data: bytes) -> list[Packet]:
        """The messages that are complete with these bytes."""
        self._buffer += data
        packets = []
        while frame := self._next_frame():
            command = struct.unpack_from("<H", frame, 4)[0]
            packets.append(Packet(command, frame[_HEADER:-_TRAILER]))
        return packets

    def _next_frame(self) -> bytes:
        """Take the next valid frame out of the buffer; empty where it is not complete yet."""
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
            if _checksum(frame) == struct.unpack(">H", frame[-_TRAILER:])[0]:
                del buffer[:length]
                return frame
            self._skip(len(_SYNC))  # a valid frame may begin inside the damaged one

    def _skip(self, count: int) -> None:
        del self._buffer[:count]
        self.skipped += count


def text_field(text: str) -> bytes:
    """Text, 8 bits a character."""
    if "\0" in text:
        raise ValueError("text with a NUL in it")
    return text.encode("latin-1") + b"\0"


def number_field(value: float) -> bytes:
    """A number as text with six significant digits (C's `%g`)."""
    return text_field(f"{value:g}")


def parse_number(text: str) -> float:
    """A finite number from text as `%g` writes it; raises LayoutError."""
    value = float(text) if _NUMBER.fullmatch(text) else inf
    if abs(value) == inf:
        raise LayoutError(f"no finite number: {text[:20]!r}")
    return value


class Fields:
    """Reads the fields of a payload in turn; `LayoutError` where it ends too early."""

    def __init__(self, payload: bytes) -> None:
        self._payload = payload
        self._at = 0

    def integers(self, layout: str) -> tuple[int, ...]:
        """Integers by their `struct` characters, little-endian."""
        layout = f"<{layout}"
        return struct.unpack(layout, self.raw(struct.calcsize(layout)))

    def integer(self, layout: str) -> int:
        """One integer."""
        return self.integers(layout)[0]

    def raw(self, size: int) -> bytes:
        """The next bytes."""
        end = self._at + size
        if end > len(self._payload):
            raise LayoutError(f"{size} bytes wanted, {self.remaining} left")
        taken, self._at = self._payload[self._at : end], end
        return taken

    def text(self) -> str:
        """Text up to its NUL."""
        end = self._payload.find(b"\0", self._at)
        if end < 0:
            raise LayoutError("text without an end")
        taken, self._at = self._payload[self._at : end], end + 1
        return taken.decode("latin-1")

    def number(self) -> float:
        """A number that is written as text."""
        return parse_number(self.text())

    @property
    def remaining(self) -> int:
        """Number of bytes not read yet."""
        return len(self._payload) - self._at
