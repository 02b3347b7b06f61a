"""The HTTP side of the control page: whom it serves, and what it refuses.

A request needs the token that is part of the printed address, must name this host, and its Origin,
if the browser sends one, must be this page. The viewer's files are served from here too, under a
policy that keeps the viewer from contacting any other machine.
"""

from __future__ import annotations

import json
import re
import secrets
import shutil
from collections.abc import Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from importlib.resources import files
from typing import TYPE_CHECKING
from urllib.parse import parse_qs, unquote, urlsplit

from app.live.web import at_home, read_file, viewer_policy
from app.live.web.bounded_server import PATIENCE, BoundedServer
from config import UserError

if TYPE_CHECKING:
    from app.live.operator.page import ControlPage

HOST = "127.0.0.1"
USUAL_PORT = 9097

_FILES = {
    "/": ("page.html", "text/html; charset=utf-8"),
    "/page.js": ("page.js", "text/javascript; charset=utf-8"),
    "/tree.js": ("tree.js", "text/javascript; charset=utf-8"),
    "/page.css": ("page.css", "text/css; charset=utf-8"),
}
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; "
    "frame-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
_VIEWER_FILE = re.compile(r"/viewer/([\w.-]*)")


class PageError(UserError):
    """The page cannot be served as requested."""


class PageServer(BoundedServer):
    """Serves one page."""

    page: ControlPage


class PageRequest(BaseHTTPRequestHandler):
    """One request."""

    server: PageServer
    timeout = PATIENCE

    @property
    def _path(self) -> str:
        """What is asked for, without the query."""
        return self.path.partition("?")[0].partition("#")[0]

    def do_GET(self) -> None:
        """The page's files, the viewer's files, and the state."""
        path = self._path
        if not self._is_same_origin():
            self._refuse(HTTPStatus.FORBIDDEN)
        elif path in _FILES:
            name, kind = _FILES[path]
            self._answer((files("app.live.operator") / name).read_bytes(), kind)
        elif path in ("/state", "/tree", "/history"):
            if self._has_token():
                self._answer(json.dumps(self._told(path)).encode(), "application/json")
            else:
                self._refuse(HTTPStatus.FORBIDDEN)
        elif wanted := _VIEWER_FILE.fullmatch(path):
            self._send_viewer(wanted[1] or "index.html")
        elif path == self.server.page.recording_path:
            self._send_recording()
        else:
            self._refuse(HTTPStatus.NOT_FOUND)

    def _told(self, path: str) -> object:
        """What is asked for, for JSON."""
        page = self.server.page
        if path == "/state":
            return page.state()
        if path == "/tree":
            return page.tree()
        (node,) = parse_qs(urlsplit(self.path).query).get("node", ["0"])[:1]
        return page.history(int(node) if node.isdecimal() else -1)

    def do_POST(self) -> None:
        """The buttons."""
        action = self.server.page.action(unquote(self._path))
        if not (self._is_same_origin() and self._has_token()):
            self._refuse(HTTPStatus.FORBIDDEN)
        elif action is None:
            self._refuse(HTTPStatus.NOT_FOUND)
        else:
            try:
                action()
            except Exception:  # the run reports it; the page goes on
                self._refuse(HTTPStatus.INTERNAL_SERVER_ERROR)
                return
            self._answer(json.dumps(self.server.page.state()).encode(), "application/json")

    def log_message(self, format: str, *arguments: object) -> None:
        """Log nothing: the terminal shows the run."""

    def _is_same_origin(self) -> bool:
        """Whether the request is addressed to this server and comes from no other page."""
        hosts, origin = self.server.page.hosts, self.headers.get("Origin")
        return self.headers.get("Host") in hosts and (
            origin is None or origin in [f"http://{host}" for host in hosts]
        )

    def _has_token(self) -> bool:
        shown = self.headers.get("X-Token", "")
        return secrets.compare_digest(shown.encode(), self.server.page.token.encode())

    def _send_viewer(self, name: str) -> None:
        """A file of the viewer, under a policy that keeps it on this machine."""
        try:
            found = read_file(name)
        except Exception:  # the run goes on
            self._refuse(HTTPStatus.BAD_GATEWAY)
            return
        if found is None:
            self._refuse(HTTPStatus.NOT_FOUND)
            return
        content, kind = found
        hosts = self.server.page.viewer_hosts
        if name == "index.html":
            content = at_home(content, hosts)
        self._answer(content, kind, f"{viewer_policy(hosts)}; frame-ancestors 'self'")

    def _send_recording(self) -> None:
        """The recording of a run that is over."""
        path = self.server.page.recording
        try:
            if path is None:
                raise FileNotFoundError
            with path.open("rb") as file:
                self.send_response(HTTPStatus.OK)
                self.send_header("Content-Type", "application/octet-stream")
                self.send_header("Content-Length", str(path.stat().st_size))
                self.end_headers()
                shutil.copyfileobj(file, self.wfile)
        except FileNotFoundError:
            self._refuse(HTTPStatus.NOT_FOUND)

    def _answer(
        self,
        body: bytes,
        kind: str,
        policy: str = _POLICY,
        headers: Mapping[str, str] | None = None,
        status: HTTPStatus = HTTPStatus.OK,
    ) -> None:
        self.send_response(status)
        all_headers = {
            "Content-Type": kind,
            "Content-Length": str(len(body)),
            "Content-Security-Policy": policy,
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
            "Cache-Control": "no-store",
            **(headers or {}),
        }
        for name, value in all_headers.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def _refuse(self, status: HTTPStatus) -> None:
        self._answer(status.phrase.encode(), "text/plain", status=status)


def listen(page: ControlPage, port: int | None) -> PageServer:
    """A server of the page; without a port on the usual one, or any if that is taken.

    Raises:
        PageError: the port is not available.
    """
    for candidate in (USUAL_PORT, 0) if port is None else (port,):
        try:
            server = PageServer((HOST, candidate), PageRequest)
        except OSError as error:
            if port is None and candidate:
                continue
            raise PageError(
                f"--control-port {candidate} on {HOST}: {error.strerror}; "
                "choose another port, or omit the option"
            ) from error
        server.page = page
        return server
    raise AssertionError("a system without a free port")
