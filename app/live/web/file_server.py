"""Serves the web viewer, and with it one recording, on threads of this process."""

from __future__ import annotations

import threading
from pathlib import Path

from app.live.web.bounded_server import BoundedServer
from app.live.web.replies import Replies

RECORDING = "recording.rrd"
"""Under this name the recording is served."""
_POLL = 0.2
_PATIENCE = 600.0
"""A download that takes longer is ended [s]: it may go over a slow line."""


class FileServer:
    """Serves from construction to `close`.

    Raises:
        OSError: the port is not available.
    """

    def __init__(
        self, host: str, port: int, *, recording: Path | None = None, hosts: str = "'self'"
    ) -> None:
        self._server = _Server((host, port), _Request)
        self._server.recording, self._server.hosts = recording, hosts
        self._thread = threading.Thread(
            target=self._server.serve_forever, args=(_POLL,), name="web viewer", daemon=True
        )
        self._thread.start()

    @property
    def port(self) -> int:
        """The port that it listens on."""
        return int(self._server.server_port)

    def close(self) -> None:
        """Serve nothing more."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


class _Server(BoundedServer):
    patience = _PATIENCE
    recording: Path | None
    hosts: str


class _Request(Replies):
    """One request."""

    server: _Server

    def do_GET(self) -> None:
        """A file of the viewer, or the recording."""
        name = self.asked.removeprefix("/") or "index.html"
        if name == RECORDING and self.server.recording is not None:
            self.send_recording(self.server.recording)
        else:
            self.send_viewer(name, self.server.hosts)
