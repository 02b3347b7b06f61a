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
from urllib.parse import unquote

from app.live.operator.page import ControlPage
from app.live.web import BoundedServer, Replies
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
_TOO_OLD = 5.0  # requests based on an older state are refused, except Stop and Pause [s]
_FAREWELL = 1.0  # time for browsers to hear how the last run ended [s]


class PageError(UserError):
    """The page cannot be served as requested."""


class PageServer(BoundedServer):
    """Serves the newest run on its own threads until the end of the `with` statement.

    Port and token stay the same from run to run, and so does the page that a person has open.

    It listens on `port`; None takes the usual one, or a free one if that is taken. `again` is
    whether another run may follow, as with `--watch`, and `seconds` real time [s]. Raises
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
        self._run = 0
        try:
            super().__init__(HOST, port, USUAL_PORT, PageRequest)
        except OSError as error:
            raise PageError(
                f"--control-port {port} on {HOST}: {error.strerror}; "
                "choose another port, or omit the option"
            ) from error
        self.hosts = (f"{HOST}:{self.port}", f"localhost:{self.port}")
        """Host names by which a browser may address this server."""

    @property
    def url(self) -> str:
        """The page with its token in the fragment, which browsers do not send."""
        return f"http://{HOST}:{self.port}/#{self.token}"

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
        return state | {
            "run": self._run,
            "told_at": self.seconds(),
            "again": self.again,
            "stopped": state["stopped"] or self.stopped,
        }

    def tree(self) -> dict[str, object]:
        """The nodes of the run, for JSON."""
        return {"run": self._run, "nodes": [] if self.page is None else self.page.tree()}

    def farewell(self) -> None:
        """Give browsers time to receive how the last run ended."""
        self.again = False
        threading.Event().wait(_FAREWELL)

    def __enter__(self) -> PageServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class PageRequest(Replies):
    """One request to the control page."""

    server: PageServer
    policy = _POLICY

    def do_GET(self) -> None:
        """The page's files, the viewer's files, and the state."""
        path, page = self.asked, self.server.page
        if not self._is_same_origin():
            self.refuse(HTTPStatus.FORBIDDEN)
        elif path in _FILES:
            name, kind = _FILES[path]
            self.answer((files("app.live.operator") / name).read_bytes(), kind)
        elif path in ("/state", "/tree"):
            if self._has_token():
                told = self.server.state() if path == "/state" else self.server.tree()
                self._send_json(told)
            else:
                self.refuse(HTTPStatus.FORBIDDEN)
        elif wanted := _VIEWER_FILE.fullmatch(path):
            hosts = "'self'" if page is None else page.viewer_hosts
            self.send_viewer(wanted[1] or "index.html", hosts)
        else:
            self.refuse(HTTPStatus.NOT_FOUND)

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

    def _send_json(self, what: object) -> None:
        self.answer(json.dumps(what).encode(), "application/json")

    def _is_same_origin(self) -> bool:
        """Whether the request is addressed to this server and comes from no other page."""
        hosts, origin = self.server.hosts, self.headers.get("Origin")
        return self.headers.get("Host") in hosts and (
            origin is None or origin in [f"http://{host}" for host in hosts]
        )

    def _has_token(self) -> bool:
        shown = self.headers.get("X-Token", "")
        if has := secrets.compare_digest(shown.encode(), self.server.token.encode()):
            self.server.keep(self.connection)
        return has

    def _is_late(self) -> bool:
        """Whether the state that the person saw is too old."""
        try:
            seen = float(self.headers.get("X-Seen", "inf"))
        except ValueError:
            return True
        return not self.server.seconds() - seen < _TOO_OLD
