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
    if chosen is not None:
        return _free(host, chosen)
    try:
        return _free(host, usual)
    except OSError:
        return _free(host, 0)


def _free(host: str, port: int) -> int:
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        probe.bind((host, port))
        probe.listen()
        return int(probe.getsockname()[1])


@dataclass(frozen=True, kw_only=True)
class Address:
    """Where the live data is served; by default a free port of the loopback address."""

    host: str = LOOPBACK
    port: int = field(default_factory=choose_port)

    @property
    def url(self) -> str:
        """What a viewer on this machine connects to."""
        return f"rerun+http://{reachable(self.host)}:{self.port}/proxy"
