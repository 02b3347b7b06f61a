"""The fields of a payload: little-endian integers, text that ends with NUL, numbers as text."""

from __future__ import annotations

import re
import struct
from math import inf

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d{1,3})?", re.IGNORECASE)


class LayoutError(ValueError):
    """A payload is not what its layout says."""


def text_field(text: str) -> bytes:
    """Text, 8 bits a character.

    Raises:
        ValueError: it holds a NUL, or a character of more than 8 bits.
    """
    if "\0" in text:
        raise ValueError("text with a NUL in it")
    return text.encode("latin-1") + b"\0"


def number_field(value: float) -> bytes:
    """A number, as text with six significant digits (C's `%g`)."""
    return text_field(f"{value:g}")


def parse_number(text: str) -> float:
    """A finite number from text as `%g` writes it.

    Raises:
        LayoutError: it is anything else.
    """
    value = float(text) if _NUMBER.fullmatch(text) else inf
    if abs(value) == inf:
        raise LayoutError(f"no finite number: {text[:20]!r}")
    return value


class Fields:
    """Takes the fields of a payload one after the other.

    Every method raises `LayoutError` where the payload ends too early. (ArNetworking itself reads
    zeros there; a wrong number is worse than none.)

    Args:
        payload: of one packet.
    """

    def __init__(self, payload: bytes) -> None:
        self._payload = payload
        self._at = 0

    def integers(self, layout: str) -> tuple[int, ...]:
        """Integers by their `struct` characters, little-endian."""
        layout = f"<{layout}"
        size = struct.calcsize(layout)
        return struct.unpack(layout, self.raw(size))

    def integer(self, layout: str) -> int:
        """One integer."""
        return self.integers(layout)[0]

    def raw(self, size: int) -> bytes:
        """The next bytes."""
        end = self._at + size
        if end > len(self._payload):
            raise LayoutError(f"{size} bytes wanted, {len(self._payload) - self._at} left")
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
    def left(self) -> int:
        """Bytes that are left."""
        return len(self._payload) - self._at
