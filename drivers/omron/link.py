"""The thread that owns the socket; commands and readings only wait for a short lock."""

import select
import socket
import threading
from collections.abc import Iterator
from contextlib import closing, suppress
from math import ceil, inf
from struct import pack

from pinocchio import SE3

from drivers.omron.arcl import Arcl
from drivers.omron.base_faults import MotionMonitor, arcl_faults, telemetry_faults
from drivers.omron.base_options import OmronOptions
from drivers.omron.commander import STOP_AFTER, Accelerations, Commander
from drivers.omron.connection import Connection, open_connection
from drivers.omron.guardian import Guardian
from drivers.omron.handshake import FromClient, FromServer
from drivers.omron.packet import encode
from drivers.omron.telemetry import Telemetry, drive_payload
from hw import Fault, HardwareError, begun, stopwatch

_CYCLE = 0.025  # interval at which the velocity is sent [s]
_RECONNECTING = 0.5  # timeout of each step of a new connection to stop the base [s]
_CLOSING = 2.0  # longest time that closing waits for the base to come to rest [s]


class Link:
    """One open connection, from `start` until it is lost or closed."""

    def __init__(
        self,
        connection: Connection,
        telemetry: Telemetry,
        settings: OmronOptions,
        accelerations: Accelerations,
        arcl: Arcl | None,
    ) -> None:
        self.lock = threading.Lock()  # protects all attributes
        self.telemetry = telemetry
        self.commander = Commander(settings.site, accelerations)
        self.monitor = MotionMonitor(settings.site)
        self.oTd = SE3.Identity()  # the device's own odometry in ours, for this connection
        self.lost = ""  # why the connection is lost; empty while connected
        self._settings = settings
        self._arcl = arcl
        self._stream, self._pending = connection.stream, connection.pending
        self._catalogue = connection.catalogue
        self._socket = connection.socket
        self._stop_frame = self._catalogue.command("stop")
        self.guardian = Guardian(self._socket, self._stop_frame, STOP_AFTER)
        self._waker, self._wakes = socket.socketpair()
        self._close_by: float | None = None

    def start(self) -> None:
        """Start the thread; HardwareError: the computer starts no more."""
        for one in (self._socket, self._waker, self._wakes):
            one.setblocking(False)
        try:
            self._thread = begun(self._run, "omron link")
        except HardwareError:
            self.guardian.leave()
            raise

    def wake(self) -> None:
        """Send the next order at once."""
        with suppress(OSError):
            self._waker.send(b".")

    def close(self) -> None:
        """Stop the base if it was commanded, wait until it is at rest, and log out."""
        with self.lock:
            if self._close_by is None:
                self._close_by = stopwatch() + _CLOSING
                if not self.commander.is_idle:
                    self.commander.stop()
        self.wake()
        self._thread.join(_CLOSING + 2.0)

    @property
    def is_closing(self) -> bool:
        """Whether it accepts no more commands."""
        return self._close_by is not None or bool(self.lost)

    @property
    def score(self) -> float | None:
        """Localisation score, 0 to 1; None where it is not sent, or its scale is unknown."""
        if self.telemetry.score is not None or self._arcl is None:
            return self.telemetry.score
        return self._arcl.state.score

    def faults(self, now: float) -> tuple[Fault, ...]:
        """What keeps the base from moving now [s]; the caller holds the lock."""
        placed_at = self.telemetry.placed_at
        age = now - placed_at if placed_at is not None else self._settings.silence
        return (
            *telemetry_faults(self.telemetry, self._settings.least_score, age, self.score),
            *(arcl_faults(self._arcl.state) if self._arcl is not None else ()),
            *((self.monitor.finding,) if self.monitor.finding is not None else ()),
        )

    def _run(self) -> None:
        why = ""
        try:
            self._serve()
        except (OSError, HardwareError) as error:
            why = str(error)
        except Exception as error:  # a bug in the driver must not leave the base driving
            why = f"the driver failed: {error!r}"
        with self.lock:
            self.lost = why or "closed"
        if why:  # discard what the system has not sent yet
            with suppress(OSError):
                self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, pack("ii", 1, 0))
        self.guardian.leave()
        for one in (self._socket, self._waker, self._wakes):
            one.close()
        if why:
            self._stop_without_connection()

    def _stop_without_connection(self) -> None:
        """Try to stop the base over the text interface, and over a new connection."""
        with suppress(OSError, HardwareError):
            if self._arcl is not None:
                self._arcl.stop()
        with suppress(OSError, HardwareError):
            patience = min(_RECONNECTING, self._settings.connect_patience)
            brief = {"connect_patience": patience, "lists_patience": patience}
            connection = open_connection(self._settings.model_copy(update=brief))
            with closing(connection.socket):
                connection.socket.sendall(connection.catalogue.command("stop"))
                connection.socket.sendall(encode(FromClient.SHUTDOWN))

    def _serve(self) -> None:
        poll = select.poll()
        poll.register(self._socket, select.POLLIN)
        poll.register(self._wakes, select.POLLIN)
        heard = due = stopwatch()
        while True:
            poll.poll(ceil(1000.0 * max(0.0, due - stopwatch())))
            is_woken = bool(_available(self._wakes)[0])
            data, is_over = _available(self._socket)
            if data:
                heard = stopwatch()
            self._take(data, heard)
            if is_over:
                raise HardwareError("the base closed it")
            now = stopwatch()
            if now - heard > self._settings.silence:
                raise HardwareError(f"nothing heard for {self._settings.silence:g} s")
            if now < due and not is_woken:
                continue
            due = max(due + _CYCLE, now)
            self.guardian.beat()
            if not self.guardian.is_running:
                raise HardwareError("the process that guards it has ended")
            with self.lock:
                frames = b"".join(self._order(now))
                may_leave = self._close_by is not None and (
                    self.commander.is_idle or now > self._close_by
                )
            self._write(frames)
            if may_leave:
                self._socket.send(encode(FromClient.SHUTDOWN))
                return

    def _take(self, data: bytes, at: float) -> None:
        packets = [*self._pending, *self._stream.feed(data)]
        self._pending.clear()
        with self.lock:
            for packet in packets:
                if packet.command == FromServer.SHUTDOWN:
                    raise HardwareError("the base shuts its server down")
                self.telemetry.take(packet, at)

    def _order(self, now: float) -> Iterator[bytes]:
        """The frame of the newest order, if any; the caller holds the lock."""
        measured = self.telemetry.velocity
        self.monitor.update(self.commander.commanded, measured, now)
        order = self.commander.order(
            now,
            measured,
            may_move=not self.faults(now),
            measured_at=-inf if self.telemetry.coarse is None else self.telemetry.coarse.at,
        )
        if order == "stop":
            yield self._stop_frame
        elif order is not None:
            yield self._catalogue.command("ratioDrive", drive_payload(order))

    def _write(self, frames: bytes) -> None:
        try:
            if not frames or self._socket.send(frames) == len(frames):
                return
        except BlockingIOError:
            pass
        raise HardwareError("it takes no commands any more")


def _available(source: socket.socket) -> tuple[bytes, bool]:
    """All that has arrived, and whether the other end has closed it."""
    data = b""
    with suppress(BlockingIOError):
        while len(data) < 1 << 20:
            more = source.recv(65536)
            if not more:
                return data, True
            data += more
            _acknowledge(source)
    return data, False


def _acknowledge(source: socket.socket) -> None:
    """Acknowledge at once: the base waits for that before it sends more."""
    if hasattr(socket, "TCP_QUICKACK") and source.family != socket.AF_UNIX:
        source.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)
