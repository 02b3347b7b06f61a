"""What a person may get wrong with an emulator, whichever it is."""

from __future__ import annotations

import socket
from collections.abc import Iterable

from config import UserError, suggest


class PortTakenError(UserError):
    """Something else listens there."""


class NoFaultError(UserError):
    """Nothing of this name can go wrong."""

    def __init__(self, name: str, faults: Iterable[str]) -> None:
        super().__init__(f"no fault is called `{name}`; {suggest(name, faults)}")


def listen(host: str, port: int) -> socket.socket:
    """A socket that listens.

    Raises:
        PortTakenError: another one does.
    """
    try:
        return socket.create_server((host, port))
    except OSError as error:
        raise PortTakenError(
            f"port {port} of {host}: {error.strerror}; choose another one"
        ) from error
