"""HTTP server of the control page.

A request must name this host and carry the token that is part of the printed address: in a header,
or in a cookie after the first visit; its Origin, if the browser sends one, must be this page. What
happens goes to browsers as server-sent events. The viewer's files are served under a policy that
keeps the viewer from contacting any other machine.
"""

from __future__ import annotations

import json
import re
import secrets
import threading
from collections.abc import Callable, Iterator
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple, Protocol
from urllib.parse import unquote

from app.live.operator.page import ControlPage, Told
from app.live.operator.run_process import RunProcess
from app.live.web import ANCESTORS, BoundedServer, Replies
from config import UserError
from hw import stopwatch

HOST = "127.0.0.1"
USUAL_PORT = 9097

_KINDS = {"html": "text/html", "js": "text/javascript", "css": "text/css"}
_FILES = {"/": "operator/page.html", "/plan.css": "plan.css"} | {
    f"/{name}": f"operator/{name}"
    for name in ("page.css", "page.js", "view.js", "tree.js", "tasks.js", "viewer.js")
}
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; "
    f"frame-src {ANCESTORS}; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
_VIEWER_FILE = re.compile(r"/viewer/([\w.-]*)")
_SAFE = ("/stop", "/pause")
_URGENT = (*_SAFE, "/acknowledge")
_TOO_OLD = 5.0  # requests based on an older state are refused, except Stop and Pause [s]
_PERIOD = 0.2  # of the events [s]
_LONGEST_BODY = 65536  # of a request [bytes]
_FAREWELL = 1.0  # time for browsers to hear how the last run ended [s]


class PageError(UserError):
    """The page cannot be served as requested."""


class Document(NamedTuple):
    """A file for the browser."""

    content: bytes | Path
    kind: str
    policy: str = ""


class Desk(Protocol):
    """What `frankie-task serve` adds to the page: tasks to start, and runs to look at."""

    banner: str
    """What it may move."""

    def get(self, path: str) -> Document | None:
        """The document at a path; None if there is none."""

    def post(self, path: str, body: bytes) -> Told | None:
        """Check or start a task; None if the path is neither."""


class PageServer(BoundedServer):
    """Serves the newest run on its own threads until the end of the `with` statement.

    Port and token stay the same from run to run, and so does the page that a person has open.

    It listens on `port`; None takes the usual one, or a free one if that is taken. `desk` is what
    is there between runs, and `seconds` real time [s]. Raises PageError: the port is not available.
    """

    urgent = tuple(f"POST {path} ".encode() for path in _URGENT)

    def __init__(
        self,
        port: int | None = None,
        *,
        desk: Desk | None = None,
        seconds: Callable[[], float] = stopwatch,
    ) -> None:
        self.token = secrets.token_urlsafe(16)
        self.ticket = secrets.token_urlsafe(16)
        """Begins paths that may be read without the token: the viewer sends no cookie."""
        self.desk = desk
        self.page: ControlPage | RunProcess | None = None
        self.seconds = seconds
        self.watching: set[object] = set()
        """Connections of browsers that watch."""
        self.closing = threading.Event()
        self.run = 0
        """Number of the run that is shown."""
        self.files = {
            path: (files("app.live") / name).read_bytes() for path, name in _FILES.items()
        }
        self._lock = threading.Lock()
        self._told: tuple[float, bytes] = (float("-inf"), b"")
        try:
            super().__init__(HOST, port, USUAL_PORT, PageRequest)
        except (OSError, RuntimeError) as error:
            why = getattr(error, "strerror", error)
            raise PageError(
                f"--control-port {port or USUAL_PORT} on {HOST}: {why}; "
                "choose another port, or end other programs"
            ) from error
        self.hosts = (f"{HOST}:{self.port}", f"localhost:{self.port}")
        """Host names by which a browser may address this server."""
        self.cookie = f"frankie-task-{self.port}"

    @property
    def url(self) -> str:
        """The page with its token in the fragment, which browsers do not send."""
        return f"http://{HOST}:{self.port}/#{self.token}"

    def serve(self, page: ControlPage | RunProcess) -> None:
        """Serve another run from now on."""
        self.page, self.run = page, self.run + 1

    def act(self, path: str) -> bool:
        """Do what a POST to a path asks for; whether there is anything."""
        if path != "/stop":
            return self.page is not None and self.page.act(path)
        if self.page is not None:
            self.page.stop()
        return True

    def state(self) -> Told:
        """The state of the run for JSON, and the time of this answer [s]."""
        idle = {"phase": "idle" if self.desk else "starting", "stopped": False}
        state = idle if self.page is None else self.page.state()
        return state | {
            "run": self.run,
            "told_at": self.seconds(),
            "desk": self.desk.banner if self.desk else "",
            "people": len(self.watching),
        }

    def events(self) -> Iterator[bytes]:
        """The server-sent events of one browser, a batch at a time, until the server closes."""
        sent: dict[str, object] = {}
        page, logged = None, 0
        while not self.closing.wait(_PERIOD if sent else 0.0):
            if self.page is not page:
                page, logged, sent = self.page, 0, {}
            batch = []
            constant = page.about() if page else None
            for kind, thing in (("about", constant), ("picture", page and page.picture())):
                if thing is not sent.get(kind, sent):
                    sent[kind] = thing
                    batch.append(_event(kind, json.dumps(thing).encode()))
            batch.append(_event("state", self._encoded()))
            if page is not None:
                logged, lines = page.log.after(logged)
                if lines:
                    batch.append(_event("log", json.dumps(lines).encode()))
            yield b"".join(batch)

    def _encoded(self) -> bytes:
        """The state as JSON, made once for all browsers."""
        with self._lock:
            if self.seconds() - self._told[0] > 0.9 * _PERIOD:
                self._told = self.seconds(), json.dumps(self.state()).encode()
            return self._told[1]

    def service_actions(self) -> None:
        """Called by the server a few times a second."""
        if self.page is not None:
            self.page.catch_up()

    def farewell(self) -> None:
        """Give browsers time to receive how the last run ended."""
        threading.Event().wait(_FAREWELL)

    def __enter__(self) -> PageServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.closing.set()
        self.close()


def _event(kind: str, data: bytes) -> bytes:
    return b"event: %s\ndata: %s\n\n" % (kind.encode(), data)


class PageRequest(Replies):
    """One request to the control page."""

    server: PageServer
    policy = _POLICY

    def do_GET(self) -> None:
        """The page's files, the viewer's files, the state, and the desk's documents."""
        path, page = self.asked, self.server.page
        if not self._is_same_origin():
            self.refuse(HTTPStatus.FORBIDDEN)
        elif path in _FILES:
            kind = f"{_KINDS[_FILES[path].rpartition('.')[2]]}; charset=utf-8"
            self.answer(self.server.files[path], kind)
        elif wanted := _VIEWER_FILE.fullmatch(path):
            hosts = "'self'" if page is None else page.viewer_hosts
            self.send_viewer(wanted[1] or "index.html", hosts)
        elif not (path.startswith(f"/{self.server.ticket}/") or self._has_token()):
            self.refuse(HTTPStatus.FORBIDDEN)
        elif path == "/events":
            self._send_events()
        elif path == "/state":
            self._send_json(self.server.state())
        elif self.server.desk and (document := self.server.desk.get(unquote(path))):
            if isinstance(document.content, Path):
                self.send_file(document.content, document.kind)
            else:
                self.answer(document.content, document.kind, document.policy)
        else:
            self.refuse(HTTPStatus.NOT_FOUND)

    def do_POST(self) -> None:
        """The buttons."""
        path = unquote(self.asked)
        if not (self._is_same_origin() and self._has_token()):
            self.refuse(HTTPStatus.FORBIDDEN)
        elif path not in _SAFE and self._is_late():
            self.refuse(HTTPStatus.CONFLICT)
        else:
            try:
                told = self._done(path)
            except Exception:  # the run reports it; the page goes on
                self.refuse(HTTPStatus.INTERNAL_SERVER_ERROR)
                return
            if told is None:
                self.refuse(HTTPStatus.NOT_FOUND)
            else:
                self._send_json(told)

    def _done(self, path: str) -> Told | None:
        """Do what a button asks for; what to answer, or None if there is no such button."""
        if self.server.desk is not None:
            length = int(self.headers.get("Content-Length", "0"))
            body = self.rfile.read(length) if 0 <= length <= _LONGEST_BODY else b""
            if (told := self.server.desk.post(path, body)) is not None:
                return told
        return self.server.state() if path == "/enter" or self.server.act(path) else None

    def _send_events(self) -> None:
        self.server.watching.add(self.connection)
        try:
            self.head(HTTPStatus.OK, "text/event-stream", None)
            for batch in self.server.events():
                self.wfile.write(batch)
        finally:
            self.server.watching.discard(self.connection)

    def _send_json(self, what: object) -> None:
        cookie = f"{self.server.cookie}={self.server.token}; Path=/; HttpOnly; SameSite=Strict"
        self.answer(json.dumps(what).encode(), "application/json", headers={"Set-Cookie": cookie})

    def _is_same_origin(self) -> bool:
        """Whether the request is addressed to this server and comes from no other page."""
        hosts, origin = self.server.hosts, self.headers.get("Origin")
        return self.headers.get("Host") in hosts and (
            origin is None or origin in [f"http://{host}" for host in hosts]
        )

    def _has_token(self) -> bool:
        shown = self.headers.get("X-Token") or self._of_cookie()
        return secrets.compare_digest(shown.encode(), self.server.token.encode())

    def _of_cookie(self) -> str:
        try:
            morsel = SimpleCookie(self.headers.get("Cookie", "")).get(self.server.cookie)
        except CookieError:
            return ""
        return morsel.value if morsel else ""

    def _is_late(self) -> bool:
        """Whether the state that the person saw is too old."""
        try:
            seen = float(self.headers.get("X-Seen", "inf"))
        except ValueError:
            return True
        return not self.server.seconds() - seen < _TOO_OLD
