"""Server of the emulated base: one thread steps its controller and serves both protocols."""

import selectors
import socket
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from math import radians
from typing import NamedTuple, Self

from extensions.emulators.common import listen
from extensions.emulators.omron.arcl_client import ArclClient
from extensions.emulators.omron.client import Client, GoneError
from extensions.emulators.omron.onboard_controller import Controller, Drive, Unicycle
from extensions.emulators.omron.options import Options, configure
from extensions.emulators.omron.requests import Requests
from hw import stopwatch

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
    """An emulated LD-60, in a `with` statement; its options may be changed while it runs."""

    def __init__(
        self,
        options: Options | None = None,
        drive: Drive | None = None,
        as_reported: Sequence[str] = (),
    ) -> None:
        self.options = options or Options()
        configure(self.options, as_reported)
        self.controller = Controller(
            drive or Unicycle(),
            self.options.teleop,
            self.options.motion,
            say=self._announce,
            clearance=lambda: self.options.clearance,
            direction=self.options.direction,
            needs_button=self.options.needs_button,
        )
        self.heard: deque[Heard] = deque(maxlen=100_000)  # motion commands, oldest first
        self.moved: deque[Moved] = deque(maxlen=100_000)  # motion of the base, oldest first
        self.text_faults: list[str] = []  # names of faults on the text interface
        self.clients: list[Client] = []
        self.text_clients: list[ArclClient] = []
        self._requests = Requests(self.controller, self.options, self._note)
        self._count = 0
        self._jumped_at = stopwatch()
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="omron emulator", daemon=True)
        self._selector = selectors.DefaultSelector()
        self._listeners: list[socket.socket] = []

    def __enter__(self) -> Self:
        """Listen."""
        self._listen(self.options.port, self._accept)
        if self.options.arcl_password:
            self._listen(self.options.arcl_port, self._accept_arcl)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()
        for client in self._everyone:
            client.socket.close()
        for listener in self._listeners:
            listener.close()
        self._selector.close()

    @property
    def port(self) -> int:
        """Port of ArNetworking."""
        return int(self._listeners[0].getsockname()[1])

    @property
    def arcl_port(self) -> int:
        """Port of the text interface."""
        return int(self._listeners[1].getsockname()[1])

    @property
    def _everyone(self) -> list[Client | ArclClient]:
        return [*self.clients, *self.text_clients]

    @contextmanager
    def held(self) -> Iterator[Controller]:
        """The controller, while its thread waits."""
        with self._lock:
            yield self.controller

    def break_off(self) -> None:
        """Reset every connection in the middle of a frame."""
        with self._lock:
            for client in self.clients:
                self._forget(client)
                client.break_off()

    def shut_down(self) -> None:
        """Announce to every client that the server shuts down."""
        with self._lock:
            for client in self.clients:
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
        for client in self._everyone:
            with self._leaving(client):
                client.serve(now)

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
        is_full = len(self.clients) >= self.options.clients
        client = Client(connection, self._requests, self.options, self._count, is_full=is_full)
        self.clients.append(client)
        self._register(client)

    def _accept_arcl(self, listener: socket.socket) -> None:
        connection = self._accepted(listener)
        if len(self.text_clients) >= self.options.arcl_clients:
            connection.close()
            return
        client = ArclClient(connection, self.controller, self.options, self.text_faults)
        self.text_clients.append(client)
        self._register(client)

    def _register(self, client: Client | ArclClient) -> None:
        def hear() -> None:
            with self._leaving(client):
                client.hear(stopwatch())

        self._selector.register(client.socket, selectors.EVENT_READ, hear)

    @staticmethod
    def _accepted(listener: socket.socket) -> socket.socket:
        connection, _ = listener.accept()
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return connection

    @contextmanager
    def _leaving(self, client: Client | ArclClient) -> Iterator[None]:
        """Forget a client that leaves; the base drives on, as the real one does."""
        try:
            yield
        except GoneError:
            self._forget(client)
            client.socket.close()

    def _forget(self, client: Client | ArclClient) -> None:
        if client in self._everyone:
            self.clients = [one for one in self.clients if one is not client]
            self.text_clients = [one for one in self.text_clients if one is not client]
            self._selector.unregister(client.socket)

    def _note(self, name: str, values: tuple[float, ...]) -> None:
        self.heard.append(Heard(stopwatch(), name, values))

    def _announce(self, line: str) -> None:
        for client in self.text_clients:
            with self._leaving(client):
                client.tell(line)
