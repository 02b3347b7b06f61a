"""A process of its own that tells the base to stop when the driver is killed or suspended.

A broken connection alone does not stop the base: it drives on until its own timeout, 2 s unless
somebody has set another. So the driver's thread writes a byte to a pipe in every cycle, and this
process, which shares the socket, sends `stop` when none comes. It is run as a script and imports
next to nothing, so that it is there in a moment.
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
_TIMES, _EVERY = 10, 0.05
"""How often a stop is repeated, and the time between two of them [s]."""


class Guardian:
    """The driver's end: starts the process, and tells it that all is well.

    Args:
        connection: the socket that both share.
        stop: the frame that stops the base.
        patience: the process acts after this time without a `beat` [s].
    """

    def __init__(self, connection: socket, stop: bytes, patience: float) -> None:
        reads, self._pipe = os.pipe()
        os.set_blocking(self._pipe, False)
        arguments = [str(connection.fileno()), str(reads), stop.hex(), str(patience)]
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", str(Path(__file__)), *arguments],
            pass_fds=(connection.fileno(), reads),
            start_new_session=True,  # Ctrl-C and the end of a terminal are not for it
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(reads)

    @property
    def pid(self) -> int:
        """Of the process."""
        return self._process.pid

    @property
    def is_there(self) -> bool:
        """Whether it still watches."""
        return self._process.poll() is None

    def beat(self) -> None:
        """All is well; where the process has ended, `is_there` tells."""
        with suppress(BlockingIOError, BrokenPipeError):
            os.write(self._pipe, _BEAT)

    def leave(self) -> None:
        """It is not needed any more: it lets go of the socket without a word."""
        with suppress(BlockingIOError, BrokenPipeError):
            os.write(self._pipe, _LEAVE)
        os.close(self._pipe)
        try:
            self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def watch(connection: int, pipe: int, stop: bytes, patience: float) -> None:
    """Until told to leave, or the driver is no more: stop the base when no beat comes.

    Args:
        connection: the socket's descriptor.
        pipe: the descriptor that beats come from.
        stop: the frame that stops the base.
        patience: longest time between two beats [s].
    """
    stops_left, wait = 0, None  # the first beat tells that the driver is ready
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
