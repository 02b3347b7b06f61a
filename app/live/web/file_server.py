"""Serves the web viewer, and with it one recording, on threads of this process."""

from __future__ import annotations

import shutil
import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from pathlib import Path

from app.live.web.bounded_server import BoundedServer
from app.live.web.viewer_files import at_home, read_file, viewer_policy

RECORDING = "recording.rrd"
"""Under this name the recording is served."""
_POLL = 0.2
_PATIENCE = 600.0
"""A download that takes longer is ended [s]: it may go over a slow line."""


class FileServer:
    """Serves from construction to `close`.

    Args:
        host: to listen on.
        port: to listen on.
        recording: a file to serve beside the viewer, if any.
        hosts: to whom the viewer's page may connect, as in a content security policy.

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


class _Request(BaseHTTPRequestHandler):
    """One request."""

    server: _Server

    def do_GET(self) -> None:
        """A file of the viewer, or the recording."""
        name = self.path.partition("?")[0].partition("#")[0].removeprefix("/") or "index.html"
        if name == RECORDING and self.server.recording is not None:
            self._send_recording(self.server.recording)
            return
        try:
            found = read_file(name)
        except Exception:  # whatever it is, the run goes on
            found = None
        if found is None:
            self._head(HTTPStatus.NOT_FOUND, "text/plain", 0)
            return
        content, kind = found
        if name == "index.html":
            content = at_home(content, self.server.hosts)
        self._head(HTTPStatus.OK, kind, len(content))
        self.wfile.write(content)

    def log_message(self, format: str, *arguments: object) -> None:
        """Log nothing: the terminal shows the run."""

    def _send_recording(self, path: Path) -> None:
        try:
            with path.open("rb") as file:
                self._head(HTTPStatus.OK, "application/octet-stream", path.stat().st_size)
                shutil.copyfileobj(file, self.wfile)
        except OSError:  # the file is gone, or the browser is
            self.close_connection = True

    def _head(self, status: HTTPStatus, kind: str, length: int) -> None:
        self.send_response(status)
        for name, value in {
            "Content-Type": kind,
            "Content-Length": str(length),
            "Content-Security-Policy": viewer_policy(self.server.hosts),
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
        }.items():
            self.send_header(name, value)
        self.end_headers()
