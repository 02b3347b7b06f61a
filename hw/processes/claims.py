"""Exclusive right to command a machine: a socket in the abstract name space of this computer."""

import hashlib
import socket
import struct
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import NamedTuple, Self

_PATIENCE = 0.3  # for the answer of a holder [s]
_LONGEST = 1000  # of an answer [bytes]


class Holder(NamedTuple):
    """The holder of a claim."""

    pid: int  # 0 if unknown
    says: str  # its introduction; may be empty


class Claim:
    """One claim; it ends with its process. `introduce` is the answer to those who ask."""

    def __init__(self, machine: str, introduce: Callable[[], str]) -> None:
        self._address, self._introduce = _address(machine), introduce
        self._socket: socket.socket | None = None

    def take(self) -> Self | None:
        """Take it; None if another process has it."""
        if self._socket is None:
            claimed = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            try:
                claimed.bind(self._address)
                claimed.listen()
            except OSError:
                claimed.close()
                return None
            self._socket = claimed
            with suppress(RuntimeError):  # without a thread it is held, and nobody answers for it
                threading.Thread(target=self._answer, args=(claimed,), daemon=True).start()
        return self

    def release(self) -> None:
        """Release it."""
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
    """The holder of the claim to a machine; None if nobody has it."""
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
