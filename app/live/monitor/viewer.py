"""Who watches: where a run is served, and the Rerun viewer that is started to show it.

The recorder serves from this process and never waits for a viewer; a viewer is a process of its own
that may come late, hang or be closed without the run noticing. Rerun's own helpers listen on every
interface of the machine; everything here listens on the loopback address unless a person says
otherwise.
"""

from __future__ import annotations

import errno
import importlib.util
import ipaddress
import os
import socket
import subprocess
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from urllib.parse import quote

from config import UserError
from hw import stopwatch

LOOPBACK = "127.0.0.1"
USUAL_PORT = 9876
"""Of the live data; what viewers expect."""
USUAL_WEB_PORT = 9090
"""Of the web viewer's page."""

_PATIENCE = 15.0
"""A viewer that is not up after this is not waited for any longer [s]."""


class ViewError(UserError):
    """A run cannot be shown as it was asked for."""


class View(StrEnum):
    """How a run is watched while it goes on."""

    AUTO = "auto"
    """A window if there is a screen, else nothing."""
    SPAWN = "spawn"
    """The native viewer, in a window."""
    WEB = "web"
    """The viewer as a page for a browser."""
    NONE = "none"


@dataclass(frozen=True, kw_only=True)
class ViewOptions:
    """What a person may choose about watching."""

    view: View = View.NONE
    host: str = LOOPBACK
    """Address to listen on."""
    port: int | None = None
    """Of the live data; None takes the usual one, or any free one if that is taken."""
    web_port: int | None = None
    """Of the page; None likewise."""


@dataclass(frozen=True, kw_only=True)
class Address:
    """Where the live data is served."""

    host: str
    port: int

    @property
    def url(self) -> str:
        """What a viewer connects to; for a viewer on this machine."""
        return f"rerun+http://{_reachable(self.host)}:{self.port}/proxy"


class Viewer:
    """The viewer of one run.

    Args:
        options: what a person chose. Everything that can be wrong with it is found out here, before
            anything is started.
        say: told what a person needs to know, a line at a time.
        environment: of the process; tells whether there is a screen.

    Raises:
        ViewError: there is no screen, a port is taken, or the address is none of this machine.
    """

    def __init__(
        self,
        options: ViewOptions,
        *,
        say: Callable[[str], None],
        environment: Mapping[str, str] = os.environ,
    ) -> None:
        self._say = say
        self._view = _chosen(options.view, environment)
        self.server: Address | None = None
        """Where the recorder serves; None if nobody watches."""
        self.page: str | None = None
        """The web viewer's address for a browser on this machine."""
        self._web_port = 0
        if self._view is View.NONE:
            return
        host = _checked(options.host)
        port = _port(host, options.port, USUAL_PORT, "--view-port")
        self.server = Address(host=host, port=port)
        if self._view is View.WEB:
            self._web_port = _port(host, options.web_port, USUAL_WEB_PORT, "--web-port", taken=port)
            source = quote(self.server.url, safe="")
            self.page = f"http://{_reachable(host)}:{self._web_port}/?url={source}"

    @contextmanager
    def showing(self, log: Path) -> Iterator[None]:
        """Show what the recorder serves, from now until the context ends.

        A window stays open with what it has got; a page is no longer served, but one that is open
        stays usable too. A viewer that does not start is told about, and is no reason not to run.

        Args:
            log: where the viewer's own messages go.
        """
        if self.server is None:
            yield
            return
        if not ipaddress.ip_address(self.server.host).is_loopback:
            self._say(
                f"warning: anybody who reaches {self.server.host} can watch this run, "
                "without a password"
            )
        with log.open("w", encoding="utf-8") as messages:
            command, port = self._command()
            process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=messages,
                stderr=messages,
                start_new_session=True,  # Ctrl-C is for the robot
            )
        try:
            if not _comes_up(process, _reachable(self.server.host), port):
                self._say(f"the viewer did not start (see {log}); the run is recorded all the same")
            elif self.page is not None:
                self._say(f"watch at {self.page}")
            yield
        finally:
            if self._view is View.WEB:
                process.terminate()
                process.wait()

    def _command(self) -> tuple[list[str], int]:
        """How to start the viewer, and a port that it listens on when it is up."""
        assert self.server is not None
        program = [str(viewer_program()), "--bind"]
        if self._view is View.WEB:
            port = self._web_port
            where = [self.server.host, "--serve-web", "--web-viewer-port", str(port)]
            return [*program, *where, self.server.url], port
        port = free_port(LOOPBACK)
        where = [LOOPBACK, "--port", str(port), "--connect", self.server.url]
        return [*program, *where, "--expect-data-soon"], port


def viewer_program() -> Path:
    """The viewer itself; the `rerun` on the path is a script that would leave it an orphan.

    Raises:
        ViewError: it is not installed.
    """
    found = importlib.util.find_spec("rerun_cli")
    program = Path(found.origin).parent / "rerun" if found and found.origin else None
    if program is None or not program.exists():
        raise ViewError("the Rerun viewer is not installed: pip install rerun-sdk, or --view none")
    return program


def _chosen(view: View, environment: Mapping[str, str]) -> View:
    screen = bool(environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY"))
    if view is View.AUTO:
        try:
            viewer_program()
        except ViewError:
            return View.NONE
        return View.SPAWN if screen else View.NONE
    if view is View.SPAWN and not screen:
        raise ViewError("--view spawn: there is no screen here; --view web shows it in a browser")
    if view is not View.NONE:
        viewer_program()
    return view


def _checked(host: str) -> str:
    try:
        return str(ipaddress.IPv4Address(host))
    except ValueError as error:
        raise ViewError(
            f"--view-host {host}: give an IPv4 address of this machine, for example {LOOPBACK}"
        ) from error


def _reachable(host: str) -> str:
    """An address that reaches `host` from this machine."""
    return LOOPBACK if ipaddress.ip_address(host).is_unspecified else host


def free_port(host: str) -> int:
    """Any port that nobody listens on."""
    return _port(host, None, 0, "")


def _port(host: str, chosen: int | None, usual: int, option: str, taken: int | None = None) -> int:
    """The chosen port, or else the usual or any other free one.

    Args:
        host: to listen on.
        chosen: by a person, who is told if it cannot be had.
        usual: what to try first if nobody chose.
        option: what a person chose it with.
        taken: a port that is spoken for.

    Raises:
        ViewError: the chosen port is taken or not allowed, or the address is not this machine's.
    """
    for port in (usual, 0) if chosen is None else (chosen,):
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                if port and port == taken:
                    raise OSError(errno.EADDRINUSE, os.strerror(errno.EADDRINUSE))
                probe.bind((host, port))
                probe.listen()
            except OSError as error:
                if error.errno == errno.EADDRNOTAVAIL:
                    raise ViewError(
                        f"--view-host {host}: this machine does not have that address"
                    ) from error
                if chosen is None and port:
                    continue
                raise ViewError(
                    f"{option} {port} on {host}: {error.strerror}; "
                    "choose another port, or leave the option out"
                ) from error
            return int(probe.getsockname()[1])
    raise AssertionError("a system without a free port")


def _comes_up(process: subprocess.Popen[bytes], host: str, port: int) -> bool:
    """Wait until a process listens; False if it ends or takes too long."""
    begun = stopwatch()
    while process.poll() is None and stopwatch() - begun < _PATIENCE:
        try:
            socket.create_connection((host, port), timeout=1.0).close()
        except OSError:
            threading.Event().wait(0.05)
        else:
            return True
    return False
