"""Connecting to the base: handshake, list of requests, first readings, and errors as one line."""

import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from config.planar import wrap
from drivers.omron.base_options import OmronOptions
from drivers.omron.handshake import (
    PROTOCOLS,
    Catalogue,
    FromServer,
    introduction,
    read_greeting,
    read_rejection,
)
from drivers.omron.packet import LayoutError, Packet, PacketStream
from drivers.omron.site import is_at_rest
from drivers.omron.telemetry import POSE, Telemetry
from hw import HardwareError, stopwatch

_NEEDED = ("ratioDrive", "stop", "updateNumbers")
_POSES_AGREE = 0.1, 0.1  # largest difference of fine and coarse pose of a base at rest [m, rad]
_LEAVES, _GOES_BACK = 1.0, 0.4
"""A stopped base leaves its mode within the first time [s]; if another program commands it, it is
back in it within the second."""


@dataclass(eq=False)
class Connection:
    """A socket past its handshake, and the requests that the server offers."""

    socket: socket.socket
    stream: PacketStream = field(default_factory=PacketStream)
    catalogue: Catalogue = field(default_factory=Catalogue)
    pending: list[Packet] = field(default_factory=list)  # arrived and not processed
    protocol: str = ""  # protocol version of the server

    def packets(self, until: float) -> Iterator[Packet]:
        """Packets that arrive until a time of `stopwatch` [s]; HardwareError: it is closed."""
        while True:
            while self.pending:
                yield self.pending.pop(0)
            remaining = until - stopwatch()
            if remaining <= 0.0:
                return
            self.socket.settimeout(remaining)
            try:
                data = self.socket.recv(65536)
            except TimeoutError:
                return
            if not data:
                raise HardwareError("it closed the connection")
            self.pending += self.stream.feed(data)


@contextmanager
def named_errors(settings: OmronOptions) -> Iterator[None]:
    """Errors name the base; those of the system become `HardwareError`."""
    where = f"Omron base at {settings.address}:{settings.port}"
    try:
        yield
    except (OSError, HardwareError) as error:
        raise HardwareError(f"{where}: {_cause(error)}") from error


def open_connection(settings: OmronOptions) -> Connection:
    """Connect, introduce ourselves, and read the requests; HardwareError with cause and hint."""
    with named_errors(settings):
        address = (settings.address, settings.port)
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


def _introduce(connection: Connection, settings: OmronOptions) -> None:
    packet = _expect(
        connection,
        settings,
        (FromServer.INTRODUCTION,),
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
    connection.socket.sendall(introduction(greeting, settings.user, settings.password))
    verdict = _expect(
        connection,
        settings,
        (FromServer.CONNECTED, FromServer.REJECTED),
        "it does not answer the introduction; is the user name alphanumeric?",
    )
    if verdict.command == FromServer.REJECTED:  # final, whatever follows
        raise HardwareError(f"refused: {read_rejection(verdict)}")


def _expect(
    connection: Connection,
    settings: OmronOptions,
    commands: tuple[FromServer, ...],
    complaint: str,
) -> Packet:
    for packet in connection.packets(stopwatch() + settings.connect_patience):
        if packet.command in commands:
            return packet
    raise HardwareError(complaint)


def _read_lists(connection: Connection, settings: OmronOptions) -> None:
    """Read the catalogue until it has everything that the driver uses."""
    catalogue = connection.catalogue
    for packet in connection.packets(stopwatch() + settings.lists_patience):
        try:
            is_list = catalogue.take(packet)
        except LayoutError as error:
            raise HardwareError(f"its list of requests cannot be read: {error}") from error
        if is_list and catalogue.has(*_NEEDED, *POSE) and catalogue.is_complete:
            return
    missing = [name for name in _NEEDED if not catalogue.has(name)]
    if missing:
        raise HardwareError(
            f"it does not offer {', '.join(missing)} to user {settings.user!r}; give the user the "
            "access groups Movement, Stop and RobotInfo in MobilePlanner"
        )


def _cause(error: Exception) -> str:
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


def first_readings(connection: Connection, settings: OmronOptions, *, claim: bool) -> Telemetry:
    """Subscribe; check that the base, stopped if `claim`, is at rest and free, or HardwareError."""
    catalogue, patience = connection.catalogue, settings.connect_patience
    lead = settings.laser_delay - settings.pose_delay
    telemetry = Telemetry(catalogue, settings.score_scale, lead)
    if claim:
        connection.socket.sendall(catalogue.command("stop"))
    connection.socket.sendall(b"".join(telemetry.requests(catalogue)))
    _listen(connection, telemetry, patience, lambda: _is_known(connection, telemetry))
    telemetry.has_encoders &= telemetry.odometry is not None  # some may list it and not send it
    if claim:
        _listen(connection, telemetry, patience, lambda: is_at_rest(telemetry.velocity))
    _check_free(telemetry)
    if not claim and telemetry.mode and not telemetry.mode.lower().startswith("stop"):
        _check_not_commanded(connection, telemetry)
    _check_poses_agree(telemetry)
    return telemetry


def _listen(
    connection: Connection, telemetry: Telemetry, patience: float, enough: Callable[[], bool]
) -> None:
    """Take packets until there is enough, or for `patience` [s]."""
    for packet in connection.packets(stopwatch() + patience):
        telemetry.take(packet, stopwatch())
        if enough():
            return


def _is_known(connection: Connection, telemetry: Telemetry) -> bool:
    has = connection.catalogue.has
    is_mode_known = bool(telemetry.mode) or not has("getModeInfo")
    is_place_known = telemetry.localisation is not None or not has("getLocState")
    return telemetry.is_complete and is_mode_known and is_place_known


def _check_free(telemetry: Telemetry) -> None:
    if not telemetry.is_complete:
        raise HardwareError("it is connected but tells no pose; has it a map, is it localised?")
    if telemetry.locked:
        raise HardwareError(
            f"it is in mode {telemetry.mode!r} ({telemetry.status}) and does not let go of it; "
            "undock it, or end that in MobilePlanner"
        )
    if not is_at_rest(telemetry.velocity):
        raise HardwareError(
            f"it moves already, in mode {telemetry.mode!r}: somebody else commands it; "
            "stop it first"
        )


def _check_not_commanded(connection: Connection, telemetry: Telemetry) -> None:
    """A stopped base leaves its mode, and returns to it if another program sends velocities."""
    mode = telemetry.mode
    connection.socket.sendall(connection.catalogue.command("stop"))
    _listen(connection, telemetry, _LEAVES, lambda: telemetry.mode != mode)
    if telemetry.mode != mode:
        _listen(connection, telemetry, _GOES_BACK, lambda: telemetry.mode == mode)
    if telemetry.mode == mode:
        raise HardwareError(
            f"it stays in mode {mode!r} although it was told to stop: another program commands it; "
            "close that first"
        )


def _check_poses_agree(telemetry: Telemetry) -> None:
    """The layout of the fine pose was never verified on a robot."""
    fine, coarse = telemetry.pose, telemetry.coarse
    assert fine is not None
    assert coarse is not None
    one, other = fine.place, coarse.place
    away = max(abs(one.x - other.x), abs(one.y - other.y))
    turned = abs(wrap(one.heading - other.heading))
    if away > _POSES_AGREE[0] or turned > _POSES_AGREE[1]:
        raise HardwareError(
            f"its two poses differ by {away:.2f} m and {turned:.2f} rad: the fine one "
            "(DataStore_RobotPoseInterpolated) is not what this driver takes it for"
        )
