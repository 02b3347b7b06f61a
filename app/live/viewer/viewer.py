"""Rerun viewer that shows a run while it goes on, or a recording.

The recorder serves from this process and never waits for a viewer; a viewer is a process of its own
that may start late, hang or be closed without affecting the run. Everything listens on the loopback
address unless the user chooses another.
"""

import ipaddress
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp

from app.choices import View
from app.run_options import RunOptions
from app.terminal import until_interrupted
from app.web import (
    LOOPBACK,
    RECORDING,
    Address,
    FileServer,
    WebFilesError,
    choose_port,
    reachable,
    viewer_address,
    viewer_environment,
    viewer_program,
    viewer_web_files,
)
from config import UserError

USUAL_PORT = 9876  # of the live data; the viewer's own default
USUAL_WEB_PORT = 9090

_PATIENCE = 1.0  # a viewer that ends this early has not started [s]


class ViewError(UserError):
    """A run cannot be shown as requested."""


class Viewer:
    """The viewer of one run; invalid options raise before anything is started.

    Raises ViewError: there is no screen, a port is taken, or the address is not this machine's.
    """

    def __init__(self, options: RunOptions, *, say: Callable[[str], None]) -> None:
        self._say = say
        self._view = _resolved(options.view)
        self.server: Address | None = None  # where the recorder serves; None without a viewer
        self.page: str | None = None
        self._open = ""  # the address that others can reach
        if self._view is View.NONE:
            return
        host, chosen = _checked(options.view_address)
        self._open = "" if ipaddress.ip_address(host).is_loopback else host
        if self._view is View.WEB:
            self._web_port = _port(host, chosen, USUAL_WEB_PORT)
            chosen = None if chosen is None else chosen + 1
        self.server = Address(host=host, port=_port(host, chosen, USUAL_PORT))
        if self._view is View.WEB:
            query = viewer_address(self.server.url)
            self.page = f"http://{reachable(host)}:{self._web_port}/{query}"

    @contextmanager
    def showing(self, log: Path) -> Iterator[None]:
        """Show what the recorder serves within the context.

        Afterwards a window stays open with the data it has, and a page stays usable in a browser
        that has it open. A viewer that does not start is reported, and the run goes on. The
        viewer's messages go to the file `log`.
        """
        if self._open:
            self._say(f"warning: anybody who can reach {self._open} can watch, without a password")
        if self.server is None:
            yield
            return
        files = None
        if self._view is View.WEB:
            files = self._serve_page(self.server)
        else:
            self._open_window(self.server, log)
        try:
            yield
        finally:
            if files is not None:
                files.close()

    def _serve_page(self, data: Address) -> FileServer | None:
        hosts = f"'self' http://{reachable(data.host)}:{data.port} http://localhost:{data.port}"
        try:
            viewer_web_files()
            files = FileServer(data.host, self._web_port, 0, hosts=hosts)
        except (WebFilesError, OSError, RuntimeError) as error:
            self._say(f"the viewer did not start ({error}); the run is still recorded")
            return None
        self._say(f"watch at {self.page}")
        return files

    def _open_window(self, data: Address, log: Path) -> None:
        command = [str(viewer_program()), "--bind", LOOPBACK, "--port", str(choose_port())]
        with log.open("w", encoding="utf-8") as messages:
            try:
                process = subprocess.Popen(
                    [*command, "--connect", data.url, "--expect-data-soon"],
                    stdin=subprocess.DEVNULL,
                    stdout=messages,
                    stderr=messages,
                    env=viewer_environment(),
                    start_new_session=True,  # Ctrl-C is for the robot
                )
            except OSError as error:
                self._say(f"the viewer did not start ({error}); the run is still recorded")
                return
        try:
            process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            return
        self._say(f"the viewer did not start (see {log}); the run is still recorded")


def has_screen() -> bool:
    """Whether a window can be opened."""
    if sys.platform == "darwin":
        return "SSH_CONNECTION" not in os.environ
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _resolved(view: View) -> View:
    """The view that the user's choice means on this machine."""
    if view is View.AUTO:
        try:
            viewer_program()
        except WebFilesError:
            return View.NONE
        return View.SPAWN if has_screen() else View.NONE
    if view is View.SPAWN and not has_screen():
        raise ViewError("--view spawn: there is no screen here; --view web shows it in a browser")
    if view is not View.NONE:
        viewer_program()
    return view


def _checked(address: str) -> tuple[str, int | None]:
    host, _, port = address.partition(":")
    try:
        return str(ipaddress.IPv4Address(host)), int(port) if port else None
    except ValueError as error:
        raise ViewError(
            f"--view-address {address}: use an IPv4 address of this machine, for example "
            f"{LOOPBACK} or {LOOPBACK}:{USUAL_WEB_PORT}"
        ) from error


def _port(host: str, chosen: int | None, usual: int) -> int:
    try:
        return choose_port(host, chosen, usual)
    except (OSError, OverflowError) as error:
        number = getattr(error, "errno", None)
        why = os.strerror(number) if number else str(error)
        raise ViewError(
            f"--view-address {host}:{chosen or usual}: {why}; "
            "choose another port or address, or omit the option"
        ) from error


_MAGICS = (b"RRF2", b"\x89MCAP0\r\n")  # how a recording begins, and a bag


def open_in_viewer(recording: Path, *, web: bool, say: Callable[[str], None]) -> None:
    """Show a recording or an MCAP file until a person ends it, in the browser or in a window.

    `say` receives the address of the page; a window takes the place of this process. Raises
    ViewError: there is no recording, or no screen for a window; WebFilesError: there is no viewer.
    """
    check_recording(recording)
    is_bag = recording.suffix == ".mcap"
    if is_bag and not recording.read_bytes().endswith(_MAGICS[1]):
        say(f"{recording}: the end is missing; what is whole is shown")
        recording, is_bag = converted(recording, Path(mkdtemp()) / RECORDING), False
    if web:
        viewer_web_files()
        with TemporaryDirectory() as folder:
            if is_bag:  # which the viewer reads in a window only
                recording = converted(recording, Path(folder) / RECORDING)
            files = FileServer(LOOPBACK, None, USUAL_WEB_PORT, recording=recording)
            origin = f"http://{LOOPBACK}:{files.port}"
            with until_interrupted():
                say(f"watch at {origin}/{viewer_address(f'{origin}/{RECORDING}')}; Ctrl-C ends it")
            files.close()
        return
    if not has_screen():
        raise ViewError("there is no screen here; --web shows the recording in a browser")
    command = [str(viewer_program()), "--bind", LOOPBACK, "--port", str(choose_port())]
    os.execve(command[0], [*command, str(recording)], viewer_environment())


def converted(bag: Path, recording: Path) -> Path:
    """The recording that Rerun makes of an MCAP file, and of what is whole of a cut one."""
    os.environ.setdefault("RUST_LOG", "off")  # what is lost is said once, not for each message
    from rerun.chunk import McapReader

    try:
        messages = McapReader(bag, recover=True).stream()
        if all(one.entity_path.startswith("/__") for one in messages.to_chunks()):
            raise ValueError("there is no whole message in it")
        messages.write_rrd(recording, application_id="frankie-task", recording_id=bag.stem)
    except (OSError, RuntimeError, ValueError) as error:
        why = " ".join(str(error).split())
        raise ViewError(f"{bag}: cannot be read ({why}); name another") from error
    return recording


def check_recording(recording: Path) -> None:
    """Raise ViewError for what the viewer could not open."""
    try:
        if not recording.is_file():
            raise ViewError(f"{recording}: the run has no recording; name another")
        with recording.open("rb") as file:
            begins = file.read(8)
    except OSError as error:
        raise ViewError(
            f"{recording}: cannot be read ({error.strerror}); name another run"
        ) from error
    if not begins.startswith(_MAGICS):
        kind = "MCAP file" if recording.suffix == ".mcap" else "recording of this version of Rerun"
        raise ViewError(f"{recording}: is no {kind}, or an empty one; name another")
