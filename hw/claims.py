"""Exclusive right to command a machine: a socket in the abstract name space of this computer."""

import hashlib
import socket
import struct
from pathlib import Path
from typing import Self

_PATIENCE = 0.3  # for the system to say who holds a claim [s]


class Claim:
    """One claim; it ends with its process."""

    def __init__(self, machine: str) -> None:
        self._address = _address(machine)
        self._socket: socket.socket | None = None

    def take(self) -> Self | None:
        """Take it; None if another process has it."""
        if self._socket is None:
            claimed = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            try:
                claimed.bind(self._address)
                claimed.listen(4096)  # nobody answers: who connects gets to know the process
            except OSError:
                claimed.close()
                return None
            self._socket = claimed
        return self

    def release(self) -> None:
        """Release it."""
        claimed, self._socket = self._socket, None
        if claimed is not None:
            claimed.close()


def holder_of(machine: str) -> int | None:
    """The process that has the claim to a machine, 0 if unknown; None if nobody has it."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as asks:
        asks.settimeout(_PATIENCE)
        try:
            asks.connect(_address(machine))
        except ConnectionRefusedError:
            return None
        except OSError:
            return 0
        told = asks.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i"))
        pid: int = struct.unpack("3i", told)[0]
        return pid


def stat_of(pid: int) -> list[str]:
    """State, parent and further fields of a process, as the system writes them; empty: unknown."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return []


def _address(machine: str) -> bytes:
    """In the abstract name space, which takes 107 bytes."""
    return b"\0frankie-task " + hashlib.sha256(machine.encode()).hexdigest()[:32].encode()
