"""Server of the emulated base: one thread steps its controller and serves both protocols."""

from __future__ import annotations

import selectors
import socket
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from math import radians
from typing import NamedTuple, Self, TypeVar

from hw.clock import stopwatch
from hw.emulators.common import listen
from hw.emulators.omron.arcl_client import ArclClient
from hw.emulators.omron.client import Client, GoneError
from hw.emulators.omron.controller import Controller, Drive, Unicycle
from hw.emulators.omron.options import Options, configure
from hw.emulators.omron.requests import Requests

_Any = TypeVar("_Any", Client, ArclClient)
_CYCLE = 0.01  # of the controller and of replies [s]


class Heard(NamedTuple):
    """A received motion command."""

    at: float  # of `stopwatch` [s]
    name: str
    values: tuple[float, ...]  # of `ratioDrive`: translation, rotation, throttle [%]

    @property
    def is_zero(self) -> bool:
        """Whether it is a stop, or of zero velocity."""
        return self.name == "stop" or 0.0 == self.values[0] == self.values[1]


class Moved(NamedTuple):
    """Motion of the base in one cycle [m/s, rad/s]."""

    at: float  # of `stopwatch` [s]
    v: float
    w: float


class OmronEmulator:
    """An emulated LD-60; use it in a `with` statement.

    Args:
        options: may be changed while it runs.
        drive: wheels and world; None for an empty one.
        faults: names of `FAULTS` that it begins with.
        as_reported: names of `AS_REPORTED`.

    Raises:
        UserError: a name is unknown.
    """

    def __init__(
        self,
        options: Options | None = None,
        drive: Drive | None = None,
        faults: tuple[str, ...] = (),
        as_reported: Sequence[str] = (),
    ) -> None:
        self.options = options or Options()
        configure(self.options, faults, as_reported)
        self.controller = Controller(
            drive or Unicycle(),
            self.options.teleop,
            self.options.motion,
            say=self._announce,
            clearance=lambda: self.options.clearance,
            heeds_throttle=self.options.heeds_throttle,
            direction=self.options.direction,
            needs_button=self.options.needs_button,
        )
        if "locked" in faults:
            self.controller.docking, self.controller.locked = 2, True
            self.controller.mode = self.controller.status = "Dock"
        if "emergency stop" in faults:
            self.controller.press()
        self.heard: deque[Heard] = deque(maxlen=100_000)  # motion commands, oldest first
        self.moved: deque[Moved] = deque(maxlen=100_000)  # motion of the base, oldest first
        self.text_faults: list[str] = []  # names of faults on the text interface
        self._requests = Requests(self.controller, self.options, self._note)
        self._clients: list[Client] = []
        self._arcl_clients: list[ArclClient] = []
        self._count = 0
        self._jumped_at = stopwatch()
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._thread: threading.Thread | None = None
        self._selector = selectors.DefaultSelector()
        self._listeners: list[socket.socket] = []

    def __enter__(self) -> Self:
        """Listen."""
        self._listen(self.options.port, self._accept)
        if self.options.arcl_password:
            self._listen(self.options.arcl_port, self._accept_arcl)
        self._thread = threading.Thread(target=self._run, name="omron emulator", daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        if self._thread is not None:
            self._thread.join()
        sockets = [one.socket for one in self._clients] + [one.socket for one in self._arcl_clients]
        for connection in (*sockets, *self._listeners):
            connection.close()
        self._selector.close()

    @property
    def port(self) -> int:
        """Port of ArNetworking."""
        return int(self._listeners[0].getsockname()[1])

    @property
    def arcl_port(self) -> int:
        """Port of the text interface."""
        return int(self._listeners[1].getsockname()[1])

    @contextmanager
    def held(self) -> Iterator[Controller]:
        """The controller, while its thread waits."""
        with self._lock:
            yield self.controller

    def freeze(self, frozen: bool = True) -> None:
        """Let the server do nothing, or go on; the base itself drives on."""
        self.options.frozen = frozen

    def break_off(self) -> None:
        """Reset every connection in the middle of a frame."""
        with self._lock:
            for client in list(self._clients):
                self._forget(client, self._clients)
                client.break_off()

    def shut_down(self) -> None:
        """Announce to every client that the server shuts down."""
        with self._lock:
            for client in self._clients:
                client.say_goodbye(stopwatch())

    def _listen(self, port: int, accept: Callable[[socket.socket], None]) -> None:
        listener = listen(self.options.host, port)
        listener.setblocking(False)
        self._listeners.append(listener)
        self._selector.register(listener, selectors.EVENT_READ, lambda: accept(listener))

    def _run(self) -> None:
        next_cycle = stopwatch()
        while not self._over.is_set():
            wait = max(0.0, next_cycle - stopwatch())
            if self.options.frozen:
                self._over.wait(wait)
                ready = []
            else:
                ready = self._selector.select(wait)
            with self._lock:
                for key, _ in ready:
                    key.data()
                now = stopwatch()
                if now >= next_cycle:
                    next_cycle = max(next_cycle + _CYCLE, now)
                    self._cycle(now)

    def _cycle(self, now: float) -> None:
        self.controller.step(now)
        self.moved.append(Moved(now, *self.controller.drive.twist()))
        if self.options.frozen:
            return
        self._jump(now)
        for client in list(self._clients):
            with self._leaving(client, self._clients):
                client.serve(now)
                client.write(now)
        for text_client in list(self._arcl_clients):
            with self._leaving(text_client, self._arcl_clients):
                text_client.last(now)

    def _jump(self, now: float) -> None:
        """Let the pose on the map jump away and back, in turn."""
        if self.options.jumps and now - self._jumped_at > self.options.jumps:
            self._jumped_at = now
            x, y, theta = self.options.offset
            away = -1.0 if x > 0.1 else 1.0
            self.options.offset = (x + 0.3 * away, y, theta + radians(5.0) * away)

    def _accept(self, listener: socket.socket) -> None:
        connection = self._accepted(listener)
        self._count += 1
        is_full = len(self._clients) >= self.options.clients
        self._add(
            Client(connection, self._requests, self.options, self._count, is_full=is_full),
            self._clients,
        )

    def _accept_arcl(self, listener: socket.socket) -> None:
        connection = self._accepted(listener)
        if len(self._arcl_clients) >= self.options.arcl_clients:
            connection.close()
            return
        client = ArclClient(connection, self.controller, self.options, self.text_faults)
        self._add(client, self._arcl_clients)

    def _add(self, client: _Any, group: list[_Any]) -> None:
        group.append(client)

        def hear() -> None:
            with self._leaving(client, group):
                client.hear(stopwatch())

        self._selector.register(client.socket, selectors.EVENT_READ, hear)

    @staticmethod
    def _accepted(listener: socket.socket) -> socket.socket:
        connection, _ = listener.accept()
        connection.setblocking(False)
        if connection.family != socket.AF_UNIX:
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return connection

    @contextmanager
    def _leaving(self, client: _Any, group: list[_Any]) -> Iterator[None]:
        """Forget a client that leaves; the base drives on, as the real one does."""
        try:
            yield
        except GoneError:
            self._forget(client, group)
            client.socket.close()

    def _forget(self, client: _Any, group: list[_Any]) -> None:
        if client in group:
            group.remove(client)
            self._selector.unregister(client.socket)

    def _note(self, name: str, values: tuple[float, ...]) -> None:
        self.heard.append(Heard(stopwatch(), name, values))

    def _announce(self, line: str) -> None:
        for client in list(self._arcl_clients):
            with self._leaving(client, self._arcl_clients):
                client.tell(line)
