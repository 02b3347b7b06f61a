"""The emulated camera: a thread that takes images from its source and sends them."""

from __future__ import annotations

import socket
import threading
from collections import deque
from contextlib import suppress
from typing import Self

import numpy as np

from hw.clock import epoch, stopwatch
from hw.emulators.errors import listen
from hw.emulators.realsense.options import Options, with_fault
from hw.emulators.realsense.sources import Shot, Source
from hw.realsense import HEAD, Introduction

_PATIENCE = 0.5
"""For a driver that does not take an image [s]."""
_NAP = 0.005
"""Longest pause between two looks at what is to be sent [s]."""


class RealSenseEmulator:
    """A D435 that is not there; use it in a `with` statement.

    It is what a cable leads to. The driver connects, and feeds with the images a software device of
    the vendor's library in its own process.

    Args:
        source: of its images.
        options: how it is set up; may be changed while it runs.
        faults: names of `FAULTS` that it begins with.

    Raises:
        NoFaultError: nothing is called so.
    """

    def __init__(
        self, source: Source, options: Options | None = None, faults: tuple[str, ...] = ()
    ) -> None:
        self.options = options or Options()
        for fault in faults:
            with_fault(self.options, fault)
        self._source = source
        self._rng = np.random.default_rng(self.options.seed)
        self._clients: list[socket.socket] = []
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._threads: list[threading.Thread] = []
        self.taken = 0
        """Images that it has taken."""

    def __enter__(self) -> Self:
        """Listen.

        Raises:
            PortTakenError: somebody else does.
        """
        options = self.options
        self._listener = listen(options.host, options.port)
        for work in (self._accept, self._take):
            thread = threading.Thread(target=work, name="realsense emulator", daemon=True)
            thread.start()
            self._threads.append(thread)
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        with suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        for thread in self._threads:
            thread.join()
        self._hang_up()

    @property
    def address(self) -> str:
        """HOST:PORT, for the settings of the driver."""
        host, port = self._listener.getsockname()[:2]
        return f"{host}:{port}"

    def unplug(self) -> None:
        """Pull the cable."""
        self.options.unplugged = True
        self._hang_up()

    def plug_in(self) -> None:
        """Put it back."""
        self.options.unplugged = False

    def freeze(self, frozen: bool = True) -> None:
        """Have it send nothing, or go on."""
        self.options.frozen = frozen

    def _hang_up(self) -> None:
        with self._lock:
            for client in self._clients:
                client.close()
            self._clients.clear()

    def _accept(self) -> None:
        options, camera = self.options, self.options.intrinsics
        introduction = Introduction(
            name=options.name,
            serial=options.serial,
            width=camera.width,
            height=camera.height,
            rate=options.rate,
            fx=camera.fx,
            fy=camera.fy,
            cx=camera.cx,
            cy=camera.cy,
            depth_units=options.depth_units,
            baseline=options.baseline,
            infrared=options.infrared,
        )
        while not self._over.is_set():
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            if options.unplugged:
                client.close()
                continue
            client.settimeout(_PATIENCE)
            with suppress(OSError):
                client.sendall(introduction.line())
            with self._lock:
                self._clients.append(client)

    def _take(self) -> None:
        due, last = stopwatch(), None
        outbox: deque[tuple[float, bytes]] = deque()
        while not self._over.is_set():
            now = stopwatch()
            while outbox and outbox[0][0] <= now:
                self._send(outbox.popleft()[1])
            if now >= due:
                due = max(due + 1.0 / self.options.rate, now)
                shot = self._source()
                if shot is not None and shot is not last:
                    last = shot
                    self._take_one(shot, outbox)
            next_one = min([due, *(one[0] for one in list(outbox)[:1])])
            self._over.wait(min(max(next_one - stopwatch(), 0.0), _NAP))

    def _take_one(self, shot: Shot, outbox: deque[tuple[float, bytes]]) -> None:
        options = self.options
        self.taken += 1
        lost, late = self._rng.random(2)
        if lost < options.drop or options.frozen:
            return
        steps = np.nan_to_num(shot.depth / np.float32(options.depth_units), nan=0.0)
        depth = np.rint(np.clip(steps, 0.0, 65535.0)).astype("<u2").tobytes()
        grey = b"" if shot.infrared is None or not options.infrared else shot.infrared.tobytes()
        captured = epoch() - (stopwatch() - shot.stamp)
        message = HEAD.pack(self.taken, captured, len(depth), len(grey)) + grey + depth
        outbox.append((shot.stamp + options.delay + options.jitter * late, message))

    def _send(self, message: bytes) -> None:
        with self._lock:
            for client in list(self._clients):
                try:
                    client.sendall(message)
                except OSError:
                    client.close()
                    self._clients.remove(client)
