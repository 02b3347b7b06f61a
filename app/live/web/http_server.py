"""HTTP server with a bounded number of threads, for the web viewer and recordings.

Clients that present the token are never disconnected for others: when there are too many
connections, the oldest unknown client is disconnected.
"""

from __future__ import annotations

import shutil
import socket
import threading
from contextlib import suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from app.live.web.viewer_files import at_home, read_file, viewer_policy
from hw import stopwatch

PATIENCE = 10.0
"""Longest duration of a connection [s]."""
MOST_CONNECTIONS = 64
"""At a time; each has a thread."""
_PACE = 0.002
"""Delay between new connections when there are too many [s]."""


class BoundedServer(ThreadingHTTPServer):
    """A thread for each connection, bounded in number and in duration."""

    patience: float | None = None
    """Replaces `PATIENCE` [s]."""
    daemon_threads = True
    request_queue_size = 4 * MOST_CONNECTIONS

    def __init__(self, *arguments: Any) -> None:
        self._begun: dict[socket.socket, float] = {}
        self._known: set[socket.socket] = set()
        self._lock = threading.Lock()
        super().__init__(*arguments)

    def keep(self, request: socket.socket) -> None:
        """Never disconnect this client for another: it has presented the token."""
        with self._lock:
            self._known.add(request)

    def process_request(self, request: Any, client_address: Any) -> None:
        """Serve a connection on its own thread, if necessary instead of an unknown client's."""
        with self._lock:
            is_free = len(self._begun) < MOST_CONNECTIONS
            strangers = (one for one in self._begun if one not in self._known)
            oldest = None if is_free else next(strangers, None)
            if oldest is not None:
                del self._begun[oldest]
            if is_free or oldest is not None:
                self._begun[request] = stopwatch()
        if oldest is not None:
            _end(oldest)
            threading.Event().wait(_PACE)
        if is_free or oldest is not None:
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    def shutdown_request(self, request: Any) -> None:
        """End a connection."""
        with self._lock:
            self._begun.pop(request, None)
            self._known.discard(request)
        super().shutdown_request(request)

    def service_actions(self) -> None:
        """End the connections that have exceeded their time; called at every poll."""
        now, patience = stopwatch(), PATIENCE if self.patience is None else self.patience
        with self._lock:
            late = [one for one, begun in self._begun.items() if now - begun > patience]
        for request in late:
            _end(request)

    def handle_error(self, request: object, client_address: object) -> None:
        """Ignore a browser that disconnects in the middle of a reply."""


def _end(request: socket.socket) -> None:
    with suppress(OSError):  # it has ended it meanwhile
        request.shutdown(socket.SHUT_RDWR)


class Replies(BaseHTTPRequestHandler):
    """Answers with a content security policy."""

    policy = "default-src 'none'"

    @property
    def asked(self) -> str:
        """The path of the request, without the query."""
        return self.path.partition("?")[0].partition("#")[0]

    def log_message(self, format: str, *arguments: object) -> None:
        """Log nothing: the terminal shows the run."""

    def answer(
        self, body: bytes, kind: str, policy: str = "", status: HTTPStatus = HTTPStatus.OK
    ) -> None:
        """Send a whole answer."""
        self._head(status, kind, len(body), policy or self.policy)
        self.wfile.write(body)

    def refuse(self, status: HTTPStatus) -> None:
        """Say no."""
        self.answer(status.phrase.encode(), "text/plain", status=status)

    def send_viewer(self, name: str, hosts: str, more: str = "") -> None:
        """Send a file of the viewer, with a policy that keeps it on this machine.

        Args:
            name: of the file.
            hosts: to which its page may connect, as in a content security policy.
            more: of that policy.
        """
        try:
            found = read_file(name)
        except Exception:  # whatever it is, the run goes on
            self.refuse(HTTPStatus.BAD_GATEWAY)
            return
        if found is None:
            self.refuse(HTTPStatus.NOT_FOUND)
            return
        content, kind = found
        if name == "index.html":
            content = at_home(content, hosts)
        self.answer(content, kind, viewer_policy(hosts) + more)

    def send_recording(self, path: Path) -> None:
        """Send a recording, if it exists."""
        try:
            with path.open("rb") as file:
                size = path.stat().st_size
                self._head(HTTPStatus.OK, "application/octet-stream", size, self.policy)
                shutil.copyfileobj(file, self.wfile)
        except FileNotFoundError:
            self.refuse(HTTPStatus.NOT_FOUND)

    def _head(self, status: HTTPStatus, kind: str, length: int, policy: str) -> None:
        self.send_response(status)
        for name, value in {
            "Content-Type": kind,
            "Content-Length": str(length),
            "Content-Security-Policy": policy,
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
            "Cache-Control": "no-store",
        }.items():
            self.send_header(name, value)
        self.end_headers()


RECORDING = "recording.rrd"
_POLL = 0.2
_PATIENCE = 600.0
"""Longest duration of a download [s]."""


class FileServer(BoundedServer):
    """Serves the web viewer and a recording from construction to `close`.

    Raises:
        OSError: the port is not available.
    """

    patience = _PATIENCE

    def __init__(
        self, host: str, port: int, *, recording: Path | None = None, hosts: str = "'self'"
    ) -> None:
        self.recording, self.hosts = recording, hosts
        super().__init__((host, port), _FileRequest)
        self.port = int(self.server_port)
        self._thread = threading.Thread(
            target=self.serve_forever, args=(_POLL,), name="web viewer", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Stop serving."""
        self.shutdown()
        self.server_close()
        self._thread.join()


class _FileRequest(Replies):
    server: FileServer

    def do_GET(self) -> None:
        name = self.asked.removeprefix("/") or "index.html"
        if name == RECORDING and self.server.recording is not None:
            self.send_recording(self.server.recording)
        else:
            self.send_viewer(name, self.server.hosts)
