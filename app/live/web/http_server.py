"""HTTP servers for the control page, the web viewer and recordings.

One thread reads requests, and a whole one gets a thread of its own. Those of strangers, of readers
with the token and of buttons are bounded, each in number a second, and others are refused at once.
So a flood leaves the loop its time, and strangers keep nobody out who has the token. Where this
computer has no thread or no file left, requests are refused; only urgent ones, which the reading
thread answers itself, are still heard.
"""

import re
import shutil
import socket
import threading
from _thread import start_new_thread  # which does not wait for the thread to run
from collections.abc import Mapping
from contextlib import suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from io import BytesIO
from multiprocessing.connection import wait
from pathlib import Path
from types import MappingProxyType
from typing import Any

from app.live.web.viewer_files import ANCESTORS, read_file, viewer_policy
from hw import stopwatch

MOST_CONNECTIONS = 64  # of a kind that have a thread
_MOST_UNREAD = 256  # connections that have not said all
RECORDING = "recording.rrd"
_AT_ONCE = 64  # new connections
_PACE = 0.004  # pause after reading, and before each answer, for the loop [s]
_RATE, _BURST = 50.0, 100.0  # requests of a kind, a second and after silence
_BUSY = b"HTTP/1.0 503 Busy\r\nRetry-After: 1\r\nContent-Length: 0\r\n\r\n"
_LENGTH = re.compile(rb"\r\ncontent-length: *(\d{1,6})", re.IGNORECASE)
_LONGEST = 1 << 17  # request [bytes]
_PATIENCE = 10.0  # a client that takes nothing for so long is disconnected [s]
_POLL = 0.1  # interval of checking whether to end [s]


class BoundedServer(ThreadingHTTPServer):
    """Serves from construction to `close`, with a bounded number of threads and requests a second.

    `port` None takes the usual one, or a free one if that is taken. Raises OSError: the port is not
    available; RuntimeError: no thread can be started.
    """

    daemon_threads = True
    request_queue_size = 1024
    token = ""
    urgent: tuple[bytes, ...] = ()
    """How requests begin that are answered at once and need no thread, as long as they are few."""

    def __init__(
        self, host: str, port: int | None, usual: int, handler: type[BaseHTTPRequestHandler]
    ) -> None:
        kinds = ("stranger", "reader", "button", "urgent")
        self._rooms = {kind: threading.Semaphore(MOST_CONNECTIONS) for kind in kinds}
        self._left = dict.fromkeys(kinds, (_BURST, 0.0))  # requests, and when that was [s]
        self._turn, self._over = threading.Lock(), threading.Event()
        try:
            super().__init__((host, usual if port is None else port), handler)
        except OSError:
            if port is not None:
                raise
            super().__init__((host, 0), handler)
        self.port = int(self.server_port)
        self._thread = threading.Thread(target=self._serve, name="web server", daemon=True)
        self._spare: socket.socket | None = socket.socket()  # to give up when no file is left
        self._thread.start()

    def close(self) -> None:
        """Stop serving."""
        self._over.set()
        self._thread.join()
        self.server_close()
        if self._spare is not None:
            self._spare.close()

    def _serve(self) -> None:
        self.socket.setblocking(False)
        unread: dict[Any, bytes] = {}  # beginnings of requests; the last that grew is at the end
        while not self._over.wait(_PACE):
            with suppress(Exception):  # whatever one request did, Stop has to be heard afterwards
                self._read(unread)
        for one in unread:
            one.close()

    def _read(self, unread: dict[Any, bytes]) -> None:
        """Take what has come, and answer the requests that are whole by now."""
        ready: list[Any] = wait([self.socket, *unread], _POLL)
        if self.socket in ready:
            ready.remove(self.socket)
            ready += self._accepted(unread)
        for one in ready:
            said, part = unread.pop(one, b""), _received(one)
            if part is None or len(said) > _LONGEST:
                one.close()
            elif _is_whole(said + part):
                self.process_request((said + part, one), None)
            else:
                unread[one] = said + part
        for one in list(unread)[:-_MOST_UNREAD]:
            one.close()
            del unread[one]
        self.service_actions()

    def _accepted(self, unread: dict[Any, bytes]) -> list[socket.socket]:
        """New connections; if no file is left for one, the next call has the file of another."""
        found: list[socket.socket] = []
        with suppress(OSError):  # no more have come, or no files are left
            while len(found) < _AT_ONCE:
                found.append(self.socket.accept()[0])
        if found:
            with suppress(OSError):
                self._spare = self._spare or socket.socket()
        elif oldest := self._spare or next(iter(unread), None):
            unread.pop(oldest, None)
            oldest.close()
            self._spare = None
        return found

    def process_request(self, request: Any, client_address: object) -> None:
        """Answer on a thread, or refuse; `request` is what was said, and the connection."""
        said, one = request
        known = self.token and self.token.encode() in said
        kind = "stranger" if not known else "button" if said.startswith(b"POST") else "reader"
        kind = "urgent" if known and said.startswith(self.urgent) else kind
        now, room = stopwatch(), self._rooms[kind]
        left, then = self._left[kind]
        left = min(_BURST, left + _RATE * (now - then))
        may = left >= 1.0 and (kind == "urgent" or self._spare is not None)
        if may := may and room.acquire(blocking=False):
            try:
                if kind == "urgent":
                    self.process_request_thread(request, room)
                else:
                    start_new_thread(self.process_request_thread, (request, room))
            except RuntimeError:  # no thread can be started
                room.release()
                may = False
        if not may:
            with suppress(OSError):  # the client has gone
                one.send(_BUSY, socket.MSG_DONTWAIT)
            one.close()
        self._left[kind] = left - may, now

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Answer when it is the turn of this one, and leave its room."""
        try:
            with self._turn:
                self._over.wait(_PACE)
            super().process_request_thread(request, None)
        finally:
            client_address.release()

    def shutdown_request(self, request: Any) -> None:
        """End a connection."""
        super().shutdown_request(request[1])

    def handle_error(self, request: object, client_address: object) -> None:
        """Ignore a browser that disconnects in the middle of a reply."""


def _received(one: socket.socket) -> bytes | None:
    """What has come; None if no more will."""
    try:
        return one.recv(_LONGEST, socket.MSG_DONTWAIT) or None
    except BlockingIOError:
        return b""
    except OSError:
        return None


def _is_whole(request: bytes) -> bool:
    head, end, body = request.partition(b"\r\n\r\n")
    length = _LENGTH.search(head)
    return bool(end) and len(body) >= int(length[1] if length else 0)


class Replies(BaseHTTPRequestHandler):
    """Answers with a content security policy."""

    policy = "default-src 'none'"
    timeout = _PATIENCE

    def setup(self) -> None:
        """Take the request, which has come already."""
        said, self.request = self.request
        super().setup()
        self.rfile = BytesIO(said)

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
