"""The right to command a machine, which one process of this computer has at a time, of any user.

It is a socket with the name of the machine in the system's abstract name space: all users see it,
it leaves no file, and the system takes it back when its holder ends, however that ends. Who asks
there is told who holds it.
"""

from __future__ import annotations

import hashlib
import socket
import struct
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import NamedTuple, Self

_PATIENCE = 0.3  # For the answer of a holder, which may be suspended [s]
_LONGEST = 1000  # Of an answer [bytes]


class Holder(NamedTuple):
    """Who holds a claim."""

    pid: int  # As the system tells; 0 if it does not
    says: str  # What it says of itself; empty if it says nothing


class Claim:
    """One claim; it ends with its process.

    Args:
        machine: its name.
        introduce: what to tell those who ask.
    """

    def __init__(self, machine: str, introduce: Callable[[], str]) -> None:
        self._address, self._introduce = _address(machine), introduce
        self._socket: socket.socket | None = None

    def take(self) -> Self | None:
        """Take it; None if somebody else has it."""
        if self._socket is None:
            claimed = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            try:
                claimed.bind(self._address)
                claimed.listen()
            except OSError:
                claimed.close()
                return None
            self._socket = claimed
            threading.Thread(target=self._answer, args=(claimed,), daemon=True).start()
        return self

    def release(self) -> None:
        """Let go of it."""
        claimed, self._socket = self._socket, None
        if claimed is not None:
            with suppress(OSError):
                claimed.shutdown(socket.SHUT_RDWR)  # wakes who waits there
            claimed.close()

    def _answer(self, claimed: socket.socket) -> None:
        while True:
            try:
                asks, _ = claimed.accept()
            except OSError:
                return
            with asks, suppress(OSError):
                asks.settimeout(_PATIENCE)
                asks.sendall(self._introduce().encode()[:_LONGEST])


def holder_of(machine: str) -> Holder | None:
    """Who has the claim to a machine; None if nobody has."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as asks:
        asks.settimeout(_PATIENCE)
        try:
            asks.connect(_address(machine))
        except ConnectionRefusedError:
            return None
        except OSError:
            return Holder(0, "")
        told = asks.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i"))
        says = b""
        with suppress(OSError):
            while len(says) < _LONGEST and (more := asks.recv(_LONGEST)):
                says += more
        return Holder(struct.unpack("3i", told)[0], says.decode(errors="replace"))


def _address(machine: str) -> bytes:
    """In the abstract name space, which takes 107 bytes."""
    return b"\0frankie-task " + hashlib.sha256(machine.encode()).hexdigest()[:32].encode()
