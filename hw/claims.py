"""Exclusive right to command a machine, for one process of this computer.

On Linux it is a socket in the abstract name space; elsewhere a locked file.
"""

import hashlib
import os
import socket
import struct
from contextlib import suppress
from fcntl import LOCK_EX, LOCK_NB, flock
from io import FileIO
from pathlib import Path
from typing import Self

_PATIENCE = 0.3  # for the system to say who holds a claim [s]
_ABSTRACT = hasattr(socket, "SO_PEERCRED")  # as on Linux: there is an abstract name space
_FILES = Path("/var/tmp")  # which all users share, and nobody empties meanwhile


class Claim:
    """One claim; it ends with its process."""

    def __init__(self, machine: str) -> None:
        self._name = _name(machine)
        self._held: socket.socket | FileIO | None = None

    def take(self) -> Self | None:
        """Take it; None if another process has it."""
        if self._held is None:
            self._held = _bound(self._name) if _ABSTRACT else _locked(self._name)
        return None if self._held is None else self

    def release(self) -> None:
        """Release it."""
        held, self._held = self._held, None
        if held is not None:
            held.close()


def holder_of(machine: str) -> int | None:
    """The process that has the claim to a machine, 0 if unknown; None if nobody has it."""
    if not _ABSTRACT:
        return _locker_of(_name(machine))
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as asks:
        asks.settimeout(_PATIENCE)
        try:
            asks.connect(_address(_name(machine)))
        except ConnectionRefusedError:
            return None
        except OSError:
            return 0
        told = asks.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i"))
        pid: int = struct.unpack("3i", told)[0]
        return pid


def _bound(name: str) -> socket.socket | None:
    claimed = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        claimed.bind(_address(name))
        claimed.listen(4096)  # nobody answers: who connects gets to know the process
    except OSError:
        claimed.close()
        return None
    return claimed


def _locked(name: str) -> FileIO | None:
    try:
        file = _file(name)
    except OSError:
        return None
    try:
        flock(file, LOCK_EX | LOCK_NB)
        file.truncate(0)
        file.write(str(os.getpid()).encode())
    except OSError:
        file.close()
        return None
    return file


def _locker_of(name: str) -> int | None:
    """The process that has locked a file, as `holder_of` tells it."""
    try:
        with _file(name) as file:
            try:
                flock(file, LOCK_EX | LOCK_NB)
            except BlockingIOError:
                return int(file.read() or 0)
            return None
    except (OSError, ValueError):
        return 0


def _file(name: str) -> FileIO:
    """The file of a claim, which every user may lock."""
    flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC
    file = FileIO(os.open(_FILES / name, flags, 0o666), "r+")
    with suppress(PermissionError):  # it is another user's, who has done so
        os.fchmod(file.fileno(), 0o666)
    return file


def _address(name: str) -> bytes:
    """In the abstract name space, which takes 107 bytes."""
    return b"\0" + name.encode()


def _name(machine: str) -> str:
    return "frankie-task " + hashlib.sha256(machine.encode()).hexdigest()[:32]
