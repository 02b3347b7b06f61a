"""The port at which an emulated Frankie is steered, and at which its images are fetched.

A line of words comes in and a line of JSON goes out, whose images follow it as bytes: unsigned
16-bit depths [mm].
"""

from __future__ import annotations

import json
import socketserver
import sys
import threading
from collections.abc import Callable, Iterable

import numpy as np

from config import UserError
from hw.emulators.frankie.emulator import FrankieEmulator
from hw.emulators.frankie.words import act

UNIT = 0.001
"""Of a depth on the wire [m]."""


class PortTakenError(UserError):
    """Something else listens there."""


class _Visitor(socketserver.StreamRequestHandler):
    """One connection."""

    server: _Port
    disable_nagle_algorithm = True

    def handle(self) -> None:
        """Answer until it goes."""
        for line in self.rfile:
            words = line.decode(errors="replace").split()
            if words[:1] == ["image"]:
                self._send_image(int(words[1]))
            else:
                told = act(self.server.emulator, " ".join(words))
                self.wfile.write(json.dumps(told).encode() + b"\n")

    def _send_image(self, after: int) -> None:
        image = self.server.emulator.image(after)
        depth = np.nan_to_num(image.depth / UNIT + 0.5, nan=0.0, posinf=0.0).astype("<u2")
        height, width = depth.shape
        told = {"number": image.number, "stamp": image.stamp, "height": height, "width": width}
        self.wfile.write(json.dumps(told).encode() + b"\n" + depth.tobytes())


class _Port(socketserver.ThreadingTCPServer):
    allow_reuse_address = True
    daemon_threads = True

    def __init__(self, emulator: FrankieEmulator) -> None:
        self.emulator = emulator
        super().__init__((emulator.places.base, emulator.places.steering), _Visitor)

    def handle_error(self, request: object, client_address: object) -> None:
        """Who leaves in the middle is forgotten."""


def serve(
    emulator: FrankieEmulator,
    *,
    lines: Iterable[str] = (),
    say: Callable[[str], None] = lambda _: None,
) -> None:
    """Be a Frankie until the lines of words end.

    Args:
        emulator: not begun yet.
        lines: what is done to it, see `WORDS`.
        say: told what has happened, as lines of JSON.

    Raises:
        UserError: something else listens at one of the places.
    """
    sys.setswitchinterval(1e-3)
    try:
        visitors = _Port(emulator)
    except OSError as error:
        port = emulator.places.steering
        raise PortTakenError(f"port {port}: {error.strerror}; choose another one") from None
    with visitors, emulator:
        threading.Thread(target=visitors.serve_forever, daemon=True).start()
        say(json.dumps({"did": "begin"}))
        for line in lines:
            say(json.dumps(act(emulator, line)))
        visitors.shutdown()
