"""Wire format of ArNetworking as a server has it, with zeros where a payload has ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite


def check_value(frame: bytes) -> int:
    """Checksum of a frame whose last two bytes do not matter."""
    total, at, left = 0, 3, len(frame) - 4
    while left > 3:
        total = (total + (frame[at] << 8 | frame[at + 1])) % 65536
        at, left = at + 2, left - 2
    return total ^ frame[at] if left > 0 else total


def seal(command: int, body: bytes = b"") -> bytes:
    """A frame with its checksum."""
    length = len(body) + 8
    head = bytes((0x0F, 0x0C)) + length.to_bytes(2, "little")
    frame = head + command.to_bytes(2, "little") + body
    return frame + check_value(frame + b"\0\0").to_bytes(2, "big")


def spoiled(frame: bytes) -> bytes:
    """The same frame with a wrong checksum."""
    return frame[:-1] + bytes((frame[-1] ^ 0x5A,))


@dataclass
class Splitter:
    """Splits the bytes of a client into messages."""

    waiting: bytes = b""

    def push(self, data: bytes) -> list[tuple[int, bytes]]:
        """The messages that are complete with these bytes: command and body."""
        self.waiting += data
        messages = []
        while len(self.waiting) >= 8:
            length = int.from_bytes(self.waiting[2:4], "little")
            if self.waiting[:2] != b"\x0f\x0c" or not 8 <= length <= 32000:
                self.waiting = self.waiting[1:]
                continue
            if len(self.waiting) < length:
                break
            frame = self.waiting[:length]
            if check_value(frame) != int.from_bytes(frame[-2:], "big"):
                self.waiting = self.waiting[1:]
                continue
            self.waiting = self.waiting[length:]
            messages.append((int.from_bytes(frame[4:6], "little"), frame[6:-2]))
        return messages


@dataclass
class Writer:
    """Builds a body field by field."""

    body: bytes = b""

    def integer(self, value: int, size: int) -> Writer:
        """A little-endian integer of `size` bytes; a negative one as its complement."""
        self.body += (int(value) % (1 << 8 * size)).to_bytes(size, "little")
        return self

    def string(self, text: str) -> Writer:
        """Text and its NUL."""
        self.body += text.encode("latin-1") + b"\0"
        return self

    def double(self, value: float) -> Writer:
        """A number as text, six significant digits."""
        return self.string(f"{value:g}")

    def raw(self, data: bytes) -> Writer:
        """Bytes as they are."""
        self.body += data
        return self


@dataclass
class Taker:
    """Reads a body field by field."""

    body: bytes
    at: int = field(default=0)

    @property
    def left(self) -> int:
        """Bytes that are left."""
        return len(self.body) - self.at

    def integer(self, size: int, *, signed: bool = False) -> int:
        """A little-endian integer of `size` bytes; 0 past the end."""
        piece = self.raw(size)
        return int.from_bytes(piece, "little", signed=signed) if len(piece) == size else 0

    def string(self) -> str:
        """Text up to its NUL, or up to the end."""
        end = self.body.find(b"\0", self.at)
        end = len(self.body) if end < 0 else end
        text, self.at = self.body[self.at : end].decode("latin-1"), min(end + 1, len(self.body))
        return text

    def double(self) -> float:
        """A number from its text; 0 where it is none."""
        try:
            value = float(self.string())
        except ValueError:
            return 0.0
        return value if isfinite(value) else 0.0

    def raw(self, size: int) -> bytes:
        """Bytes as they are; fewer past the end."""
        piece, self.at = self.body[self.at : self.at + size], min(self.at + size, len(self.body))
        return piece
