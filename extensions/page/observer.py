"""The page as an observer of a run: JSON lines over a socket to the process that serves it.

Out go `about`, `state`, `log` and `picture`; in come the paths of buttons, a line each.
"""

from __future__ import annotations

import json
import secrets
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from importlib.util import find_spec

from app.live import LiveRun, Observer, Snapshot
from app.terminal import until_interrupted
from app.web import LOOPBACK, listening
from config import UserError, extra
from extensions.page.control_page import ControlPage, Told
from extensions.page.plan import Plan

USUAL_PORT = 9097

_PERIOD = 0.2  # of the state [s]
_PATIENCE = 5.0  # for the process of the page to end [s]


class PageError(UserError):
    """The page cannot be served as requested."""


def require_server() -> None:
    """Raise PageError where the extra with the server is missing."""
    if missing := [name for name in ("starlette", "uvicorn") if find_spec(name) is None]:
        raise PageError(f"the page needs {' and '.join(missing)}: {extra('page')}")


def page(argument: str, run: LiveRun) -> RunPage:
    """The page of a run; the argument is a port, or none for the usual one or a free one.

    `fd=N` tells a process that serves the page already; when that is gone the run ends. Raises
    PageError: it cannot be served.
    """
    shown = run.shown
    contents = ControlPage(
        run.control,
        shown.tree,
        injector=run.injector,
        info=run.info,
        plan=Plan(shown.scene, shown.robot.base.size),
        viewer=run.viewer,
        hooks=run.hooks,
        may_force=run.may_force,
    )
    try:
        if argument.startswith("fd="):
            return RunPage(contents, socket.socket(fileno=int(argument[3:])), run.control.stop)
        require_server()
        port = int(argument) if argument else None
    except (ValueError, OSError) as error:
        raise PageError(f"--with page:{argument}: give a port, as page:{USUAL_PORT}") from error
    try:
        served = Served(port)
    except (OSError, OverflowError) as error:
        why = getattr(error, "strerror", error)
        raise PageError(
            f"--with page:{port or USUAL_PORT} on {LOOPBACK}: {why}; "
            "choose another port, or end other programs"
        ) from error
    run.say(f"control at {served.url}")
    return RunPage(contents, served.socket, lambda: None, served, run.say)


class Served:
    """A process that serves the page of this one; raises OSError: it cannot be started."""

    def __init__(self, port: int | None) -> None:
        token = secrets.token_urlsafe(16)
        with listening(LOOPBACK, port, USUAL_PORT) as listener:
            self.url = f"http://{LOOPBACK}:{listener.getsockname()[1]}/#{token}"
            self.socket, theirs = socket.socketpair()
            with theirs:
                given = listener.fileno(), theirs.fileno()
                self._process = subprocess.Popen(
                    [sys.executable, "-P", "-m", "extensions.page.server", *map(str, given)],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.DEVNULL,
                    pass_fds=given,
                    start_new_session=True,  # Ctrl-C is for this process
                )
        assert self._process.stdin is not None
        with self._process.stdin as channel:
            channel.write(token.encode())  # where no other program can read it

    def close(self) -> None:
        """Wait until the process has told its browsers of the end."""
        try:
            self._process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


class RunPage(Observer):
    """Tells another process of the page over a connection; `served` is that process if it is ours.

    `gone` is called when the other side has ended. Raises PageError: no thread can be started.
    """

    resumes = acknowledges = True

    def __init__(
        self,
        page: ControlPage,
        connection: socket.socket,
        gone: Callable[[], None],
        served: Served | None = None,
        say: Callable[[str], None] = print,
    ) -> None:
        self._page, self._socket, self._gone = page, connection, gone
        self._served, self._say = served, say
        self._closing, self._is_gone = threading.Event(), False
        self._threads = [
            threading.Thread(target=target, name=f"page {name}", daemon=True)
            for name, target in (("out", self._tell), ("in", self._listen))
        ]
        try:
            for thread in self._threads:
                thread.start()
        except RuntimeError as error:
            self.close()
            text = f"the page cannot be served ({error}); end other programs and start again"
            raise PageError(text) from error

    def show(self, snapshot: Snapshot) -> None:
        """Take a tick; raises ConnectionError: the process of the page has ended."""
        if self._is_gone:
            raise ConnectionError("its process has ended")
        self._page.show(snapshot)

    def finish(self) -> None:
        """Say that the robot is at rest."""
        self._page.finish()

    def end(self, outcome: str, explanation: str, *, stay: bool) -> None:
        """Show how the run ended; a page of ours stays until Ctrl-C."""
        self._page.end(outcome, explanation)
        if self._served is None or not stay:
            return
        before = signal.signal(signal.SIGTERM, signal.default_int_handler)
        try:
            with until_interrupted():
                self._say(f"the page stays at {self._served.url}; Ctrl-C ends it")
        finally:
            signal.signal(signal.SIGTERM, before)

    def close(self) -> None:
        """Tell the rest, and end."""
        self._closing.set()
        if self._threads[0].is_alive():
            self._threads[0].join(_PERIOD * 10)
        with suppress(OSError):  # the other process is gone
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()
        if self._served is not None:
            self._served.close()

    def _listen(self) -> None:
        with suppress(OSError), self._socket.makefile("r", encoding="utf-8") as lines:
            for line in lines:
                with suppress(Exception):  # the run reports it; Stop has to work afterwards
                    self._page.act(line.rstrip("\n"))
        if not self._closing.is_set():
            self._is_gone = True
            self._gone()

    def _tell(self) -> None:
        page, logged, last = self._page, 0, False
        sent: Told | None = None
        with suppress(OSError):
            self._send(about=page.about())
            while not last:
                last = self._closing.wait(_PERIOD)
                with suppress(Exception):  # whatever it is, the state is told afterwards
                    page.catch_up()
                logged, lines = page.log.after(logged)
                shown = page.picture()
                news: Told = {"state": page.state()}
                news |= {"log": lines} if lines else {}
                news |= {"picture": shown} if shown is not sent else {}
                sent = shown
                self._send(**news)

    def _send(self, **news: object) -> None:
        self._socket.sendall(json.dumps(news).encode() + b"\n")
