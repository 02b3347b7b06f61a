"""Server of the emulated camera: one thread accepts drivers, one takes and sends images."""

import select
import socket
import threading
import time
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict
from typing import Self, TypeAlias

import numpy as np
import numpy.typing as npt

from drivers.realsense import HEAD, RESET, Introduction
from extensions.emulators.common import chosen, listen
from extensions.emulators.realsense.options import AS_REPORTED, Options
from extensions.emulators.realsense.sources import Shot, Source
from hw import epoch, stopwatch

_PATIENCE = 0.5  # timeout of sending an image [s]
_NAP = 0.005  # longest pause of the sending loop [s]
_RESETTING = 0.3  # time that a reset takes [s]
_BEGINS = 3  # when a reported behaviour begins that needs a while [s]
_ON_ITS_WAY = 0.035  # latency of images whose stamps may be those of their arrival [s]
_FIFTY_YEARS = 50 * 365.25 * 86400.0

Pixels: TypeAlias = npt.NDArray[np.uint16]
Message: TypeAlias = tuple[int, float, Pixels]  # number, calendar time [s], depth


class RealSenseEmulator:
    """An emulated D435, in a `with` statement; its options may be changed while it runs."""

    def __init__(
        self,
        source: Source,
        options: Options | None = None,
        as_reported: Sequence[str] = (),
    ) -> None:
        self.options = options = options or Options()
        options.as_reported = ways = chosen(as_reported, AS_REPORTED, "camera")
        options.rate = min(options.rate, 15) if "usb2" in ways else options.rate
        options.firmware = "05.08.15.00" if "old-firmware" in ways else options.firmware
        options.delay += _ON_ITS_WAY if "metadata-lost" in ways else 0.0
        self._hangs, self._away_until = False, 0.0
        self._last: Message | None = None
        self._first = 0  # number of the first image with a client
        self._source = source
        self._rng = np.random.default_rng(self.options.seed)
        self._clients: list[socket.socket] = []
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._threads: list[threading.Thread] = []
        self.taken = self.resets = 0  # numbers of images and resets

    def __enter__(self) -> Self:
        """Listen."""
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
        """Close connections and refuse new ones."""
        self.options.unplugged = True
        self._hang_up()

    def plug_in(self) -> None:
        """Accept connections again."""
        self.options.unplugged = self._hangs = False

    def reset(self) -> None:
        """Restart, as the vendor's library may request."""
        self._hangs &= "hangs-until-reset" not in self.options.as_reported
        self.resets += 1
        self._away_until = stopwatch() + _RESETTING
        self._hang_up()

    def _hang_up(self) -> None:
        with self._lock:
            for client in self._clients:
                client.close()
            self._clients.clear()

    def _accept(self) -> None:
        options = self.options
        introduction = Introduction(
            name=options.name,
            serial=options.serial,
            **asdict(options.intrinsics),
            rate=options.rate,
            depth_units=options.depth_units,
            baseline=options.baseline,
            infrared=options.infrared,
            firmware=options.firmware,
            recommended=Options.firmware,
        )
        while not self._over.is_set():
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            if options.unplugged or stopwatch() < self._away_until:
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
            if self._is_asked_to_reset():
                self.reset()
            while outbox and outbox[0][0] <= now:
                self._send(outbox.popleft()[1])
            if now >= due:
                begun = time.thread_time()
                shot = self._source()
                took = time.thread_time() - begun  # of a core that the robot's program needs, too
                due = max(due + 1.0 / self.options.rate, now + 2.0 * took)
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
        depth = np.rint(np.clip(steps, 0.0, 65535.0)).astype("<u2")
        captured = epoch() - (stopwatch() - shot.stamp)
        number, captured, depth = self._as_reported(self.taken, captured, depth)
        if self._hangs:
            return
        grey = b"" if shot.infrared is None or not options.infrared else shot.infrared.tobytes()
        message = HEAD.pack(number, captured, depth.nbytes, len(grey)) + grey + depth.tobytes()
        outbox.append((shot.stamp + options.delay + options.jitter * late, message))

    def _as_reported(self, number: int, captured: float, depth: Pixels) -> Message:
        ways, last = self.options.as_reported, self._last or (number, captured, depth)
        if not self._first and self._clients:
            self._first = number
        seconds = (number - self._first) / self.options.rate
        later, spell = seconds > _BEGINS, seconds % 3.0 > 2.0
        self._hangs |= (
            bool(ways & {"hangs-until-reset", "hangs-until-replugged"}) and seconds == _BEGINS
        )
        if ("freezes" in ways and spell) or ("repeats-images" in ways and number % 3 == 0):
            return last
        if "stamps-back" in ways and spell:
            captured -= 0.3
        if "stamps-future" in ways and spell:
            captured += 0.2
        if "stamps-far" in ways and later:
            captured += _FIFTY_YEARS
        if "metadata-lost" in ways and later:
            captured += _ON_ITS_WAY
        if "picture-frozen" in ways and spell:
            depth = last[2]
        if "zero-depth" in ways and spell:
            depth = np.where(self._rng.random(depth.shape) < 1e-3, depth, depth.dtype.type(0))
        if "incomplete" in ways and number % 5 == 0:
            depth = depth.copy()
            depth[len(depth) // 2 :] = 0
        self._last = number, captured, depth
        return self._last

    def _is_asked_to_reset(self) -> bool:
        with self._lock, suppress(OSError):
            asking, _, _ = select.select(self._clients, (), (), 0.0)
            return any([client.recv(1) == RESET for client in asking])
        return False

    def _send(self, message: bytes) -> None:
        with self._lock:
            for client in list(self._clients):
                try:
                    client.sendall(message)
                except OSError:
                    client.close()
                    self._clients.remove(client)
