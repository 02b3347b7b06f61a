"""HTTP servers on a thread of their own: for the control page, the web viewer and recordings.

Connections that say nothing keep nobody out: when there are too many, the oldest of a client that
has not presented the token is ended. One that has is never ended for another.
"""

import shutil
import socket
import threading
from collections.abc import Mapping
from contextlib import suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from types import MappingProxyType
from typing import Any

from app.live.web.viewer_files import ANCESTORS, read_file, viewer_policy

MOST_CONNECTIONS = 64  # at a time; each has a thread
_PACE = 0.004  # between new connections, so that a flood of them leaves the loop its time [s]
RECORDING = "recording.rrd"
_PATIENCE = 10.0  # a client that is silent for so long is disconnected [s]
_POLL = 0.1  # interval of checking whether to end [s]


class BoundedServer(ThreadingHTTPServer):
    """Serves from construction to `close`, with a bounded number of threads.

    `port` None takes the usual one, or a free one if that is taken. Raises OSError: the port is not
    available.
    """

    daemon_threads = True
    request_queue_size = 4 * MOST_CONNECTIONS

    def __init__(
        self, host: str, port: int | None, usual: int, handler: type[BaseHTTPRequestHandler]
    ) -> None:
        self._open: dict[socket.socket, bool] = {}  # oldest first: whether it is of a stranger
        self._lock = threading.Lock()
        try:
            super().__init__((host, usual if port is None else port), handler)
        except OSError:
            if port is not None:
                raise
            super().__init__((host, 0), handler)
        self.port = int(self.server_port)
        self._thread = threading.Thread(
            target=self.serve_forever, args=(_POLL,), name="web server", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Stop serving."""
        self.shutdown()
        self.server_close()
        self._thread.join()

    def keep(self, request: socket.socket) -> None:
        """Never end this connection for another: the client has presented the token."""
        with self._lock:
            self._open[request] = False

    def process_request(self, request: Any, client_address: Any) -> None:
        """Serve a connection on its own thread, if necessary instead of a stranger's."""
        with self._lock:
            oldest = None
            if len(self._open) >= MOST_CONNECTIONS:
                oldest = next((one for one, strange in self._open.items() if strange), request)
                self._open.pop(oldest, None)
            if oldest is not request:
                self._open[request] = True
        threading.Event().wait(_PACE)
        if oldest is not None:
            with suppress(OSError):  # the client has ended it meanwhile
                oldest.shutdown(socket.SHUT_RDWR)
        if oldest is request:
            self.shutdown_request(request)
        else:
            super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        """End a connection."""
        with self._lock:
            self._open.pop(request, None)
        super().shutdown_request(request)

    def handle_error(self, request: object, client_address: object) -> None:
        """Ignore a browser that disconnects in the middle of a reply."""


class Replies(BaseHTTPRequestHandler):
    """Answers with a content security policy."""

    policy = "default-src 'none'"
    timeout = _PATIENCE

    @property
    def asked(self) -> str:
        """The path of the request, without the query."""
        return self.path.partition("?")[0].partition("#")[0]

    def log_message(self, format: str, *arguments: object) -> None:
        """Log nothing: the terminal shows the run."""

    def answer(
        self,
        body: bytes,
        kind: str,
        policy: str = "",
        status: HTTPStatus = HTTPStatus.OK,
        headers: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        """Send a whole answer."""
        self.head(status, kind, len(body), policy, headers)
        self.wfile.write(body)

    def send_file(self, path: Path, kind: str) -> None:
        """Send a file that may be long."""
        with path.open("rb") as file:
            self.head(HTTPStatus.OK, kind, path.stat().st_size)
            shutil.copyfileobj(file, self.wfile)

    def refuse(self, status: HTTPStatus) -> None:
        """Say no."""
        self.answer(status.phrase.encode(), "text/plain", status=status)

    def send_viewer(self, name: str, hosts: str) -> None:
        """Send a file of the viewer, whose page may connect to `hosts` only."""
        try:
            found = read_file(name, hosts)
        except Exception:  # whatever it is, the run goes on
            self.refuse(HTTPStatus.BAD_GATEWAY)
            return
        if found is None:
            self.refuse(HTTPStatus.NOT_FOUND)
        else:
            self.answer(*found, f"{viewer_policy(hosts)}; frame-ancestors {ANCESTORS}")

    def head(
        self,
        status: HTTPStatus,
        kind: str,
        length: int | None,
        policy: str = "",
        headers: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        """Send the head of an answer; the length of its body [bytes] is None if it goes on."""
        self.send_response(status)
        known = {} if length is None else {"Content-Length": str(length)}
        for name, value in {
            **known,
            **headers,
            "Content-Type": kind,
            "Content-Security-Policy": policy or self.policy,
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
            "Cache-Control": "no-store",
        }.items():
            self.send_header(name, value)
        self.end_headers()


class FileServer(BoundedServer):
    """Serves the web viewer, and a recording if there is one.

    Raises OSError: the port is not available.
    """

    def __init__(
        self,
        host: str,
        port: int | None,
        usual: int,
        *,
        recording: Path | None = None,
        hosts: str = "'self'",
    ) -> None:
        self.recording, self.hosts = recording, hosts
        super().__init__(host, port, usual, _FileRequest)


class _FileRequest(Replies):
    server: FileServer

    def do_GET(self) -> None:
        name = self.asked.removeprefix("/") or "index.html"
        if name != RECORDING or self.server.recording is None:
            self.send_viewer(name, self.server.hosts)
            return
        self.send_file(self.server.recording, "application/octet-stream")
