"""Addresses and free ports of this machine."""

import ipaddress
import socket
from dataclasses import dataclass, field

LOOPBACK = "127.0.0.1"


def reachable(host: str) -> str:
    """An address that reaches `host` from this machine."""
    return LOOPBACK if ipaddress.ip_address(host).is_unspecified else host


def choose_port(host: str = LOOPBACK, chosen: int | None = None, usual: int = 0) -> int:
    """The chosen port, which must be free; if None, the usual one, or a free one.

    Raises OSError: the chosen port is taken or not allowed, or the address is not this machine's.
    """
    with listening(host, chosen, usual) as probe:
        return int(probe.getsockname()[1])


def listening(host: str, port: int | None, usual: int) -> socket.socket:
    """A socket that listens on a port; None takes the usual one, or a free one; OSError."""
    try:
        return socket.create_server((host, usual if port is None else port), backlog=1024)
    except OSError:
        if port is not None:
            raise
        return socket.create_server((host, 0), backlog=1024)


@dataclass(frozen=True, kw_only=True)
class Address:
    """Where the live data is served; by default a free port of the loopback address."""

    host: str = LOOPBACK
    port: int = field(default_factory=choose_port)

    @property
    def url(self) -> str:
        """What a viewer on this machine connects to."""
        return f"rerun+http://{reachable(self.host)}:{self.port}/proxy"
