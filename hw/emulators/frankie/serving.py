"""The port at which an emulated Frankie is steered: words come in, lines of JSON go out."""

from __future__ import annotations

import json
import socketserver
import sys
import threading
from collections.abc import Callable, Iterable

from hw.emulators.common import PortTakenError, be_prompt
from hw.emulators.frankie.emulator import FrankieEmulator
from hw.emulators.frankie.words import act

_PRIORITY = 5
"""Below that of the emulated arm."""


class _Visitor(socketserver.StreamRequestHandler):
    """One connection."""

    server: _Port
    disable_nagle_algorithm = True

    def handle(self) -> None:
        """Answer until it goes."""
        for line in self.rfile:
            told = act(self.server.emulator, line.decode(errors="replace"))
            self.wfile.write(json.dumps(told).encode() + b"\n")


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

    It asks for real-time priority and goes on without where it is not granted.

    Args:
        emulator: not begun yet.
        lines: what is done to it, see `WORDS`.
        say: told what has happened, as lines of JSON.

    Raises:
        UserError: something else listens at one of the places.
    """
    sys.setswitchinterval(1e-3)
    be_prompt(_PRIORITY)
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
