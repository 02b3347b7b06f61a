"""Opening a connection, step by step; each that fails says in one line why, and what to do."""

from __future__ import annotations

import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from hw.clock import stopwatch
from hw.omron.fields import LayoutError
from hw.omron.handshake import (
    PROTOCOLS,
    Catalogue,
    FromServer,
    introduction,
    read_greeting,
    read_rejection,
)
from hw.omron.packet import Packet, PacketStream
from hw.omron.settings import OmronSettings
from hw.omron.telemetry import POSE
from hw.robot import HardwareError

NEEDED = ("ratioDrive", "stop", "updateNumbers")
"""What the driver cannot do without."""


@dataclass(eq=False)
class Connection:
    """A socket past its handshake, and what the server offers."""

    socket: socket.socket
    stream: PacketStream = field(default_factory=PacketStream)
    catalogue: Catalogue = field(default_factory=Catalogue)
    pending: list[Packet] = field(default_factory=list)
    """Packets that have arrived and were not looked at."""
    protocol: str = ""
    """Version that the server announces."""

    def send(self, frames: bytes) -> None:
        """While connecting: waits until the system has taken them."""
        self.socket.sendall(frames)

    def packets(self, until: float) -> Iterator[Packet]:
        """What arrives until a moment of the computer's clock [s].

        Raises:
            HardwareError: the server has closed the connection.
        """
        while True:
            while self.pending:
                yield self.pending.pop(0)
            left = until - stopwatch()
            if left <= 0.0:
                return
            self.socket.settimeout(left)
            try:
                data = self.socket.recv(65536)
            except TimeoutError:
                return
            if not data:
                raise HardwareError("it closed the connection")
            self.pending += self.stream.feed(data)


@contextmanager
def said_of(settings: OmronSettings) -> Iterator[None]:
    """Errors name the base; those of the system become `HardwareError`."""
    where = f"Omron base at {settings.host}:{settings.port}"
    try:
        yield
    except (OSError, HardwareError) as error:
        raise HardwareError(f"{where}: {_cause(error)}") from error


def open_connection(settings: OmronSettings) -> Connection:
    """A connection that may be used.

    Raises:
        HardwareError: there is none, with cause and hint.
    """
    with said_of(settings):
        address = (settings.host, settings.port)
        connection = Connection(
            socket.create_connection(address, timeout=settings.connect_patience)
        )
        try:
            connection.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            _introduce(connection, settings)
            _read_lists(connection, settings)
        except BaseException:
            connection.socket.close()
            raise
        return connection


def _introduce(connection: Connection, settings: OmronSettings) -> None:
    """Greeting, introduction, verdict."""
    packet = _expect(
        connection,
        settings,
        lambda packet: packet.command == FromServer.INTRODUCTION,
        "it does not greet as ArNetworking does; check the port (7272 is usual), and whether the "
        "base has started",
    )
    try:
        greeting = read_greeting(packet)
    except LayoutError as error:
        raise HardwareError(f"its greeting cannot be read: {error}") from error
    if greeting.protocol not in PROTOCOLS:
        known = ", ".join(PROTOCOLS)
        raise HardwareError(
            f"it speaks protocol version {greeting.protocol!r}; this driver knows {known}"
        )
    connection.protocol = greeting.protocol
    connection.send(introduction(greeting, settings.user, settings.password))
    verdict = _expect(
        connection,
        settings,
        lambda packet: packet.command in (FromServer.CONNECTED, FromServer.REJECTED),
        "it does not answer the introduction; is the user name alphanumeric?",
    )
    if verdict.command == FromServer.REJECTED:  # final, whatever comes after it
        raise HardwareError(f"refused: {read_rejection(verdict)}")


def _expect(
    connection: Connection,
    settings: OmronSettings,
    wanted: Callable[[Packet], bool],
    complaint: str,
) -> Packet:
    for packet in connection.packets(stopwatch() + settings.connect_patience):
        if wanted(packet):
            return packet
    raise HardwareError(complaint)


def _read_lists(connection: Connection, settings: OmronSettings) -> None:
    """Learn the names, until all that the driver uses are there."""
    catalogue = connection.catalogue
    for packet in connection.packets(stopwatch() + settings.lists_patience):
        try:
            is_list = catalogue.take(packet)
        except LayoutError as error:
            raise HardwareError(f"its list of requests cannot be read: {error}") from error
        if is_list and catalogue.has(*NEEDED, *POSE) and catalogue.groups:
            return
    missing = [name for name in NEEDED if not catalogue.has(name)]
    if missing:
        raise HardwareError(
            f"it does not offer {', '.join(missing)} to user {settings.user!r}; give the user the "
            "access groups Movement, Stop and RobotInfo in MobilePlanner"
        )


def _cause(error: Exception) -> str:
    """In words, with a hint."""
    match error:
        case HardwareError():
            return str(error)
        case TimeoutError():
            return "it does not answer; check the address, the cable and that the base is on"
        case ConnectionRefusedError():
            return "nothing listens on this port; check the port, and that the base has started"
        case socket.gaierror():
            return "no computer has this name; write its address, like 10.10.10.10"
        case ConnectionResetError() | BrokenPipeError():
            return "it broke off the connection; look whether it has restarted"
        case _:
            return f"{error.__class__.__name__}: {error}".replace("\n", " ")
