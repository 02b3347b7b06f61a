"""Watchdog process that stops the base when the driver is killed or suspended.

A broken connection does not stop the base before its own timeout, 2 s by default. So the driver's
thread writes a byte to a pipe in every cycle, and this process, which shares the socket, sends
`stop` when none comes. It is run as a script and imports little, so that it starts at once.
"""

import os
import select
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from socket import socket

_BEAT, _LEAVE = b".", b"q"
_TIMES, _EVERY = 10, 0.05  # number of stops that are sent, and the time between two of them [s]


class Guardian:
    """The driver's end; the process sends the frame `stop` after `patience` [s] without a beat."""

    def __init__(self, connection: socket, stop: bytes, patience: float) -> None:
        reads, self._pipe = os.pipe()
        os.set_blocking(self._pipe, False)
        arguments = [str(connection.fileno()), str(reads), stop.hex(), str(patience)]
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-I", "-S", str(Path(__file__)), *arguments],
                pass_fds=(connection.fileno(), reads),
                start_new_session=True,  # not ended by Ctrl-C or with the terminal
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
        except OSError:
            os.close(self._pipe)
            raise
        finally:
            os.close(reads)
        self.pid = self._process.pid

    @property
    def is_running(self) -> bool:
        """Whether the process runs."""
        return self._process.poll() is None

    def beat(self) -> None:
        """Send a heartbeat; where the process has ended, `is_running` is False."""
        with suppress(BlockingIOError, BrokenPipeError):
            os.write(self._pipe, _BEAT)

    def leave(self) -> None:
        """End the process without a stop."""
        with suppress(BlockingIOError, BrokenPipeError):
            os.write(self._pipe, _LEAVE)
        os.close(self._pipe)
        try:
            self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def watch(connection: int, pipe: int, stop: bytes, patience: float) -> None:
    """Send stops while no heartbeat comes, until the driver leaves or has ended."""
    stops_left, wait = 0, None  # the driver is ready with the first heartbeat
    while True:
        if select.select([pipe], [], [], wait)[0]:
            beats = os.read(pipe, 4096)
            if _LEAVE in beats:
                return
            if beats:
                stops_left, wait = _TIMES, patience
                continue
            stops_left, wait = max(stops_left, 1), _EVERY  # the driver has ended
            for _ in range(stops_left):
                _send(connection, stop)
                select.select([], [], [], _EVERY)
            return
        if stops_left:
            stops_left, wait = stops_left - 1, _EVERY
            _send(connection, stop)
        else:
            wait = None


def _send(connection: int, frame: bytes) -> None:
    with suppress(OSError):
        os.write(connection, frame)


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    watch(int(sys.argv[1]), int(sys.argv[2]), bytes.fromhex(sys.argv[3]), float(sys.argv[4]))
