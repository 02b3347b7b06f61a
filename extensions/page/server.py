"""HTTP server of the control page, by Starlette on uvicorn.

A request must name this host and carry the token that is part of the printed address: in a header,
or in a cookie after the first visit; its Origin, if the browser sends one, must be this page. What
happens goes to browsers as server-sent events. The viewer's files are served under a policy that
keeps the viewer from contacting any other machine.

One thread answers all requests, so that Stop needs none; the desk's own work has other threads.
"""

from __future__ import annotations

import asyncio
import json
import re
import secrets
import socket
import sys
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import suppress
from http import HTTPStatus
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route
from uvicorn.protocols.http.h11_impl import H11Protocol

from app.web import ANCESTORS, LOOPBACK, listening, read_file, viewer_policy
from extensions.page.control_page import Told
from extensions.page.observer import USUAL_PORT, PageError
from extensions.page.run_process import RunLink, ShownPage
from hw import stopwatch

_KINDS = {"html": "text/html", "js": "text/javascript", "css": "text/css"}
_STATIC = files(__package__) / "static"
_FILES = {"/": _STATIC / "page.html"} | {
    f"/{name}": _STATIC / name
    for name in ("page.css", "plan.css", "page.js", "view.js", "tree.js", "tasks.js", "viewer.js")
}
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; "
    f"frame-src {ANCESTORS}; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
_VIEWER_FILE = re.compile(r"/viewer/([\w.-]*)")
_SAFE = ("/stop", "/pause")
_TOO_OLD = 5.0  # requests based on an older state are refused, except Stop and Pause [s]
_PERIOD = 0.2  # of the events [s]
_LONGEST_BODY = 65536  # of a request [bytes]
_SILENT = 10.0  # a connection that has asked for nothing for so long is ended [s]
_FAREWELL = 1.0  # time for browsers to hear how the last run ended [s]
_UP = 10.0  # for the server to end [s]
_SOON = 0.005  # interval of asking whether it has begun [s]


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


class PageServer:
    """Serves the newest run on a thread of its own until the end of the `with` statement.

    Port and token stay the same from run to run, and so does the page that a person has open.

    It listens on `port`; None takes the usual one, or a free one if that is taken; or at
    `listener`. `desk` is what is there between runs, and `seconds` real time [s]. Raises PageError:
    the port is not available, or there is no thread.
    """

    def __init__(
        self,
        port: int | None = None,
        *,
        desk: Desk | None = None,
        listener: socket.socket | None = None,
        token: str = "",
        seconds: Callable[[], float] = stopwatch,
    ) -> None:
        self.token = token or secrets.token_urlsafe(16)
        self.ticket = secrets.token_urlsafe(16)
        """Begins paths that may be read without the token: the viewer sends no cookie."""
        self.desk = desk
        self.page: ShownPage | None = None
        self.seconds = seconds
        self.run = 0
        """Number of the run that is shown."""
        self.watching = 0
        """Number of browsers that watch."""
        self._told: tuple[float, bytes] = (float("-inf"), b"")
        try:
            self._socket = listener or listening(LOOPBACK, port, USUAL_PORT)
            self.port = int(self._socket.getsockname()[1])
            self.hosts = (f"{LOOPBACK}:{self.port}", f"localhost:{self.port}")
            """Host names by which a browser may address this server."""
            self.cookie = f"frankie-task-{self.port}"
            self._server = _server(self)
            self._thread = threading.Thread(target=self._serve, name="page server", daemon=True)
            self._thread.start()
            while not self._server.started and self._thread.is_alive():
                threading.Event().wait(_SOON)
        except (OSError, OverflowError, RuntimeError) as error:
            why = getattr(error, "strerror", error)
            raise PageError(
                f"--port {port or USUAL_PORT} on {LOOPBACK}: {why}; "
                "choose another port, or end other programs"
            ) from error

    @property
    def url(self) -> str:
        """The page with its token in the fragment, which browsers do not send."""
        return f"http://{LOOPBACK}:{self.port}/#{self.token}"

    def serve(self, page: ShownPage) -> None:
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
            "people": self.watching,
        }

    async def events(self) -> AsyncIterator[bytes]:
        """The server-sent events of one browser, a batch at a time, until the server closes."""
        sent: dict[str, object] = {}
        page, logged = None, 0
        self.watching += 1
        try:
            while not self._server.should_exit:
                if self.page is not page:
                    page, logged, sent = self.page, 0, {}
                if page is not None:
                    with suppress(Exception):  # whatever it is, Stop has to be heard afterwards
                        page.catch_up()
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
                await asyncio.sleep(_PERIOD)
        finally:
            self.watching -= 1

    def _encoded(self) -> bytes:
        """The state as JSON, made once for all browsers."""
        if self.seconds() - self._told[0] > 0.9 * _PERIOD:
            self._told = self.seconds(), json.dumps(self.state()).encode()
        return self._told[1]

    def _serve(self) -> None:
        with suppress(SystemExit):  # of uvicorn, which has said why in its log
            self._server.run(sockets=[self._socket])

    def __enter__(self) -> PageServer:
        return self

    def __exit__(self, *_: object) -> None:
        threading.Event().wait(_FAREWELL * bool(self.watching))
        self._server.should_exit = True
        self._thread.join(_UP)
        self._socket.close()


def _event(kind: str, data: bytes) -> bytes:
    return b"event: %s\ndata: %s\n\n" % (kind.encode(), data)


class _Impatient(H11Protocol):
    """Ends connections on which nobody asks for anything."""

    def connection_made(self, transport: Any) -> None:
        super().connection_made(transport)
        self.loop.call_later(_SILENT, self._end_if_silent)

    def _end_if_silent(self) -> None:
        request: object = self.cycle
        if request is None and not self.transport.is_closing():
            self.transport.close()


def _server(page: PageServer) -> uvicorn.Server:
    requests = _Requests(page)
    routes = [
        Route("/{path:path}", requests.get, methods=["GET"]),
        Route("/{path:path}", requests.post, methods=["POST"]),
    ]
    config = uvicorn.Config(
        Starlette(routes=routes, exception_handlers={404: _refused, 405: _refused, 500: _refused}),
        http=_Impatient,
        loop="asyncio",
        lifespan="off",
        ws="none",
        log_config=None,
        log_level="critical",
        access_log=False,
        server_header=False,
        h11_max_incomplete_event_size=2 * _LONGEST_BODY,
        timeout_graceful_shutdown=1,
    )
    return uvicorn.Server(config)


class _Requests:
    """Answers requests to the page."""

    def __init__(self, server: PageServer) -> None:
        self.server = server

    async def get(self, request: Request) -> Response:
        """The page's files, the viewer's files, the state, and the desk's documents."""
        server, path = self.server, request.url.path
        if not self._is_same_origin(request):
            return _refusal(HTTPStatus.FORBIDDEN)
        if path in _FILES:
            kind = f"{_KINDS[_FILES[path].name.rpartition('.')[2]]}; charset=utf-8"
            return _answer(_FILES[path].read_bytes(), kind)
        if wanted := _VIEWER_FILE.fullmatch(path):
            return await run_in_threadpool(self._viewer, wanted[1] or "index.html")
        if not (path.startswith(f"/{server.ticket}/") or self._has_token(request)):
            return _refusal(HTTPStatus.FORBIDDEN)
        if path == "/events":
            return StreamingResponse(server.events(), headers=_headers("text/event-stream"))
        if path == "/state":
            return self._json(server.state())
        if server.desk and (document := await run_in_threadpool(server.desk.get, path)):
            if isinstance(document.content, Path):
                return FileResponse(document.content, headers=_headers(document.kind))
            return _answer(document.content, document.kind, document.policy)
        return _refusal(HTTPStatus.NOT_FOUND)

    async def post(self, request: Request) -> Response:
        """The buttons."""
        path = request.url.path
        if not (self._is_same_origin(request) and self._has_token(request)):
            return _refusal(HTTPStatus.FORBIDDEN)
        if path not in _SAFE and self._is_late(request):
            return _refusal(HTTPStatus.CONFLICT)
        try:
            told = await self._done(path, request)
        except ClientDisconnect:
            raise
        except Exception:  # the run reports it; the page goes on
            return _refusal(HTTPStatus.INTERNAL_SERVER_ERROR)
        return _refusal(HTTPStatus.NOT_FOUND) if told is None else self._json(told)

    async def _done(self, path: str, request: Request) -> Told | None:
        """Do what a button asks for; what to answer, or None if there is no such button."""
        server = self.server
        if path not in _SAFE and server.desk is not None:
            body = await _body(request)
            told: Told | None = await run_in_threadpool(server.desk.post, path, body)
            if told is not None:
                return told
        return server.state() if path == "/enter" or server.act(path) else None

    def _viewer(self, name: str) -> Response:
        """A file of the viewer, whose page may connect to the data of the run only."""
        page = self.server.page
        hosts = "'self'" if page is None else page.viewer_hosts
        try:
            found = read_file(name)
        except Exception:  # whatever it is, the page goes on
            return _refusal(HTTPStatus.BAD_GATEWAY)
        if found is None:
            return _refusal(HTTPStatus.NOT_FOUND)
        return _answer(*found, f"{viewer_policy(hosts)}; frame-ancestors {ANCESTORS}")

    def _json(self, what: object) -> Response:
        cookie = f"{self.server.cookie}={self.server.token}; Path=/; HttpOnly; SameSite=Strict"
        return JSONResponse(what, headers=_headers("application/json") | {"Set-Cookie": cookie})

    def _is_same_origin(self, request: Request) -> bool:
        """Whether the request is addressed to this server and comes from no other page."""
        hosts, origin = self.server.hosts, request.headers.get("Origin")
        return request.headers.get("Host") in hosts and (
            origin is None or origin in [f"http://{host}" for host in hosts]
        )

    def _has_token(self, request: Request) -> bool:
        given = request.headers.get("X-Token") or request.cookies.get(self.server.cookie, "")
        return secrets.compare_digest(given.encode(), self.server.token.encode())

    def _is_late(self, request: Request) -> bool:
        """Whether the state that the person saw is too old."""
        try:
            seen = float(request.headers.get("X-Seen", "inf"))
        except ValueError:
            return True
        return not self.server.seconds() - seen < _TOO_OLD


async def _body(request: Request) -> bytes:
    """What a request brings; nothing if that is too long."""
    body = b""
    async for part in request.stream():
        body += part
        if len(body) > _LONGEST_BODY:
            return b""
    return body


def _headers(kind: str, policy: str = "") -> dict[str, str]:
    return {
        "Content-Type": kind,
        "Content-Security-Policy": policy or _POLICY,
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "no-referrer",
        "Cache-Control": "no-store",
    }


def _answer(content: bytes, kind: str, policy: str = "") -> Response:
    return Response(content, headers=_headers(kind, policy))


def _refusal(status: HTTPStatus) -> Response:
    return Response(status.phrase, status, headers=_headers("text/plain"))


async def _refused(request: Request, error: Exception) -> Response:
    return _refusal(HTTPStatus(getattr(error, "status_code", 500)))


def _serve_one(listener: str, connection: str) -> None:
    """Serve the page of the process that started this one, until that is gone."""
    token = sys.stdin.read()
    link = RunLink(socket.socket(fileno=int(connection)))
    with PageServer(listener=socket.socket(fileno=int(listener)), token=token) as server:
        server.serve(link)
        link.hear()


if __name__ == "__main__":
    _serve_one(*sys.argv[1:])
