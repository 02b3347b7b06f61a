"""A page in the browser that pauses, steps and stops a run, with the viewer embedded.

It is served on the loopback address only. A request needs the token that is part of the printed
address, must name this host, and its Origin, if the browser sends one, must be this page. The
viewer's files are proxied here, so that a content security policy keeps the viewer from contacting
any other machine.
"""

from __future__ import annotations

import json
import re
import secrets
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from http import HTTPStatus
from http.client import HTTPException
from http.server import BaseHTTPRequestHandler
from importlib.resources import files
from typing import TYPE_CHECKING
from urllib.parse import quote, unquote, urlsplit
from urllib.request import urlopen

from app.live.nodes import tip
from app.live.operator.bounded_server import PATIENCE, BoundedServer
from app.live.operator.control import Control
from config import UserError
from hw import INJECTABLE

if TYPE_CHECKING:
    from app.live.nodes import NodeInfo
    from app.live.snapshot import Snapshot

HOST = "127.0.0.1"
USUAL_PORT = 9097

_FILES = {
    "/": ("page.html", "text/html; charset=utf-8"),
    "/page.js": ("page.js", "text/javascript; charset=utf-8"),
    "/page.css": ("page.css", "text/css; charset=utf-8"),
}
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; "
    "frame-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
_VIEWER_POLICY = (
    "default-src 'none'; script-src 'self' 'unsafe-inline' 'wasm-unsafe-eval'; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; "
    "worker-src 'self' blob:; manifest-src 'self'; connect-src 'self' {data}; "
    "frame-ancestors 'self'; base-uri 'none'; form-action 'none'"
)
_VIEWER_FILE = re.compile(r"/viewer/([\w.-]*)")
_OFFERED = tuple(name for name, fault in INJECTABLE.items() if not fault.of_world)
"""The faults that every robot can be given."""
_SHUTDOWN_POLL = 0.1
"""How often the server checks whether it is to end [s]."""


class PageError(UserError):
    """The page cannot be served as requested."""


@dataclass(frozen=True, kw_only=True)
class WebViewer:
    """The web viewer that the page embeds."""

    files: str
    """Where its files are served, for example `http://127.0.0.1:9090`."""
    data: str
    """What it connects to, for example `rerun+http://127.0.0.1:9876/proxy`."""

    @property
    def data_origin(self) -> str:
        """The only other origin that the viewer may contact."""
        return f"http://{urlsplit(self.data).netloc}"

    @property
    def path(self) -> str:
        """Its path on the page's own server."""
        return f"/viewer/?url={quote(self.data, safe='')}&hide_welcome_screen=1"


class ControlPage:
    """Serves the page on threads of its own, from construction to the end of the `with` statement.

    Args:
        control: what the buttons control.
        tree: the nodes of the tree, in preorder.
        inject: injects a fault, by its name in `INJECTABLE`.
        clear: clears the injected faults.
        viewer: embedded in the page, if there is one.
        port: to listen on; None takes the usual one, or any free one if that is taken.

    Raises:
        PageError: the port is not available.
    """

    def __init__(
        self,
        control: Control,
        tree: Sequence[NodeInfo],
        *,
        inject: Callable[[str], None],
        clear: Callable[[], None],
        viewer: WebViewer | None = None,
        port: int | None = None,
    ) -> None:
        self.viewer = viewer
        self.token = secrets.token_urlsafe(16)
        self._control = control
        self._tree = tree
        self._snapshot: Snapshot | None = None
        self.actions: Mapping[str, Callable[[], None]] = {
            "/pause": control.pause,
            "/resume": control.resume,
            "/step": control.step,
            "/next": control.run_to_next_change,
            "/stop": control.stop,
            "/acknowledge": control.acknowledge,
            "/clear": clear,
            **{f"/fault/{name}": partial(inject, name) for name in _OFFERED},
        }
        self._server = _listen(self, port)
        self._thread = threading.Thread(
            target=self._server.serve_forever, args=(_SHUTDOWN_POLL,), name="page", daemon=True
        )
        self._thread.start()

    @property
    def port(self) -> int:
        """The port that it listens on."""
        return int(self._server.server_port)

    @property
    def url(self) -> str:
        """The page with its token, in the part of the address that browsers do not send."""
        return f"http://{HOST}:{self.port}/#{self.token}"

    @property
    def hosts(self) -> tuple[str, ...]:
        """Host names under which a browser may address this server."""
        return (f"{HOST}:{self.port}", f"localhost:{self.port}")

    def show(self, snapshot: Snapshot) -> None:
        """Set the tick that the page shows."""
        self._snapshot = snapshot

    def state(self) -> dict[str, object]:
        """What the page shows, for JSON."""
        state, snapshot = self._control.state, self._snapshot
        shown: dict[str, object] = {
            "paused": state.paused,
            "why": state.why,
            "stopped": state.stopped,
            "ticks": state.ticks,
            "emergency": state.emergency,
            "pressed": state.pressed,
            "injectable": list(_OFFERED),
            "viewer": self.viewer.path if self.viewer else None,
        }
        if snapshot is not None:
            index = tip(snapshot.nodes)
            shown |= {
                "time": snapshot.stamp,
                "node": self._tree[index].name,
                "status": snapshot.nodes[index].status.value.lower(),
                "message": snapshot.nodes[index].message,
                "faults": [fault.text for fault in snapshot.state.faults],
            }
        return shown

    def __enter__(self) -> ControlPage:
        return self

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


class _Server(BoundedServer):
    page: ControlPage


class _Request(BaseHTTPRequestHandler):
    """One request."""

    server: _Server
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
        elif path == "/state":
            if self._has_token():
                self._answer(json.dumps(self.server.page.state()).encode(), "application/json")
            else:
                self._refuse(HTTPStatus.FORBIDDEN)
        elif (wanted := _VIEWER_FILE.fullmatch(path)) and self.server.page.viewer:
            self._proxy(self.server.page.viewer, wanted[1])
        else:
            self._refuse(HTTPStatus.NOT_FOUND)

    def do_POST(self) -> None:
        """The buttons."""
        action = self.server.page.actions.get(unquote(self._path))
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

    def _proxy(self, viewer: WebViewer, name: str) -> None:
        """A file of the viewer, under a policy that keeps it on this machine."""
        try:
            with urlopen(f"{viewer.files}/{name}", timeout=PATIENCE) as reply:
                body, kind = reply.read(), reply.headers.get_content_type()
                coding = reply.headers.get("Content-Encoding")
        except (HTTPException, OSError, ValueError):
            self._refuse(HTTPStatus.BAD_GATEWAY)
            return
        policy = _VIEWER_POLICY.format(data=viewer.data_origin)
        self._answer(body, kind, policy, {"Content-Encoding": coding} if coding else {})

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


def _listen(page: ControlPage, port: int | None) -> _Server:
    for candidate in (USUAL_PORT, 0) if port is None else (port,):
        try:
            server = _Server((HOST, candidate), _Request)
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
