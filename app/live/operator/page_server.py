"""HTTP server of the control page.

A request must carry the token that is part of the printed address and name this host; its Origin,
if the browser sends one, must be this page. The viewer's files are served under a policy that keeps
the viewer from contacting any other machine.
"""

from __future__ import annotations

import json
import re
import secrets
import threading
from collections.abc import Callable
from http import HTTPStatus
from importlib.resources import files
from urllib.parse import parse_qs, unquote, urlsplit

from app.live.operator.page import ControlPage
from app.live.web import PATIENCE, BoundedServer, Replies
from config import UserError
from hw import stopwatch

HOST = "127.0.0.1"
USUAL_PORT = 9097

_FILES = {
    "/": ("page.html", "text/html; charset=utf-8"),
    "/page.js": ("page.js", "text/javascript; charset=utf-8"),
    "/view.js": ("view.js", "text/javascript; charset=utf-8"),
    "/tree.js": ("tree.js", "text/javascript; charset=utf-8"),
    "/page.css": ("page.css", "text/css; charset=utf-8"),
}
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; "
    "frame-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
_VIEWER_FILE = re.compile(r"/viewer/([\w.-]*)")
_SAFE = ("/stop", "/pause")
_TOO_OLD = 5.0
"""Requests based on an older state are refused, except Stop and Pause [s]."""
_SHUTDOWN_POLL = 0.1
"""How often the server checks whether it is to end [s]."""
_LISTENING, _FAREWELL = 2.0, 1.0
"""A browser that has asked so recently has so long to hear how the run ended [s]."""


class PageError(UserError):
    """The page cannot be served as requested."""


class PageServer(BoundedServer):
    """Serves the newest run on its own threads until the end of the `with` statement.

    Port and token stay the same from run to run, and so does the page that a person has open.

    Args:
        port: to listen on; None takes the usual one, or a free one if that is taken.
        again: whether another run may follow, as with `--watch`.
        seconds: real time from an arbitrary start [s].

    Raises:
        PageError: the port is not available.
    """

    def __init__(
        self,
        port: int | None = None,
        *,
        again: bool = False,
        seconds: Callable[[], float] = stopwatch,
    ) -> None:
        self.token = secrets.token_urlsafe(16)
        self.again = again
        self.stopped = False
        self.page: ControlPage | None = None
        self.seconds = seconds
        self._run, self._asked = 0, -_LISTENING
        self._bind(port)
        self._thread = threading.Thread(
            target=self.serve_forever, args=(_SHUTDOWN_POLL,), name="page", daemon=True
        )
        self._thread.start()

    def _bind(self, port: int | None) -> None:
        for candidate in (USUAL_PORT, 0) if port is None else (port,):
            try:
                super().__init__((HOST, candidate), PageRequest)
                return
            except OSError as error:
                if port is None and candidate:
                    continue
                raise PageError(
                    f"--control-port {candidate} on {HOST}: {error.strerror}; "
                    "choose another port, or omit the option"
                ) from error

    @property
    def port(self) -> int:
        """The port that it listens on."""
        return int(self.server_port)

    @property
    def address(self) -> str:
        """Of the page, without the token."""
        return f"http://{HOST}:{self.port}"

    @property
    def url(self) -> str:
        """The page with its token in the fragment, which browsers do not send."""
        return f"{self.address}/#{self.token}"

    @property
    def hosts(self) -> tuple[str, ...]:
        """Host names by which a browser may address this server."""
        return (f"{HOST}:{self.port}", f"localhost:{self.port}")

    def serve(self, page: ControlPage) -> None:
        """Serve another run from now on."""
        self.page, self._run = page, self._run + 1

    def stop(self) -> None:
        """End the run; between two runs, the next one."""
        self.stopped = True
        if self.page is not None:
            self.page.stop()

    def action(self, path: str) -> Callable[[], None] | None:
        """The action of a POST to a path; None if there is none."""
        if path == "/stop":
            return self.stop
        return None if self.page is None else self.page.action(path)

    def state(self) -> dict[str, object]:
        """The state of the run for JSON, and the time of this answer [s]."""
        state = {"phase": "starting", "stopped": False} if self.page is None else self.page.state()
        self._asked = self.seconds()
        return state | {
            "run": self._run,
            "told_at": self._asked,
            "again": self.again,
            "stopped": state["stopped"] or self.stopped,
        }

    def tree(self) -> dict[str, object]:
        """The nodes of the run, for JSON."""
        return {"run": self._run, "nodes": [] if self.page is None else self.page.tree()}

    def history(self, node: int) -> list[dict[str, object]]:
        """The changes of a node, for JSON; empty for an invalid number."""
        return [] if self.page is None else self.page.history(node)

    def farewell(self) -> None:
        """Give browsers time to receive how the last run ended."""
        self.again = False
        if self.seconds() - self._asked < _LISTENING:
            threading.Event().wait(_FAREWELL)

    def __enter__(self) -> PageServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.shutdown()
        self.server_close()
        self._thread.join()


class PageRequest(Replies):
    """One request to the control page."""

    server: PageServer
    timeout = PATIENCE
    policy = _POLICY

    def do_GET(self) -> None:
        """The page's files, the viewer's files, and the state."""
        path, page = self.asked, self.server.page
        if not self._is_same_origin():
            self.refuse(HTTPStatus.FORBIDDEN)
        elif path in _FILES:
            name, kind = _FILES[path]
            self.answer((files("app.live.operator") / name).read_bytes(), kind)
        elif path in ("/state", "/tree", "/history"):
            if self._has_token():
                self._send_json(self._state_of(path))
            else:
                self.refuse(HTTPStatus.FORBIDDEN)
        elif wanted := _VIEWER_FILE.fullmatch(path):
            hosts = "'self'" if page is None else page.viewer_hosts
            self.send_viewer(wanted[1] or "index.html", hosts, "; frame-ancestors 'self'")
        elif page is not None and page.recording and path == page.recording_path:
            self.send_recording(page.recording)
        else:
            self.refuse(HTTPStatus.NOT_FOUND)

    def _send_json(self, what: object) -> None:
        self.answer(json.dumps(what).encode(), "application/json")

    def _state_of(self, path: str) -> object:
        if path == "/state":
            return self.server.state()
        if path == "/tree":
            return self.server.tree()
        (node,) = parse_qs(urlsplit(self.path).query).get("node", ["0"])[:1]
        return self.server.history(int(node) if node.isdecimal() else -1)

    def do_POST(self) -> None:
        """The buttons."""
        path = unquote(self.asked)
        action = self.server.action(path)
        if not (self._is_same_origin() and self._has_token()):
            self.refuse(HTTPStatus.FORBIDDEN)
        elif action is None:
            self.refuse(HTTPStatus.NOT_FOUND)
        elif path not in _SAFE and self._is_late():
            self.refuse(HTTPStatus.CONFLICT)
        else:
            try:
                action()
            except Exception:  # the run reports it; the page goes on
                self.refuse(HTTPStatus.INTERNAL_SERVER_ERROR)
                return
            self._send_json(self.server.state())

    def _is_same_origin(self) -> bool:
        """Whether the request is addressed to this server and comes from no other page."""
        hosts, origin = self.server.hosts, self.headers.get("Origin")
        return self.headers.get("Host") in hosts and (
            origin is None or origin in [f"http://{host}" for host in hosts]
        )

    def _has_token(self) -> bool:
        shown = self.headers.get("X-Token", "")
        has = secrets.compare_digest(shown.encode(), self.server.token.encode())
        if has:
            self.server.keep(self.connection)
        return has

    def _is_late(self) -> bool:
        """Whether the state that the person saw is too old."""
        try:
            seen = float(self.headers.get("X-Seen", "inf"))
        except ValueError:
            return True
        return not self.server.seconds() - seen < _TOO_OLD
