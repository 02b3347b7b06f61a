"""Opens a recording in the Rerun viewer, in a window or in the browser."""

from __future__ import annotations

import os
import subprocess
import threading
from collections.abc import Callable, Sequence
from os.path import isfile
from pathlib import Path
from typing import Any

from app.live.viewer.viewer import USUAL_WEB_PORT, ViewError, has_screen
from app.live.web import (
    FileServer,
    viewer_address,
    viewer_environment,
    viewer_program,
    viewer_web_files,
)
from app.live.web.http_server import RECORDING
from app.live.web.ports import LOOPBACK, Address, choose_port
from app.terminal import until_interrupted

_LOOK_PERIOD = 0.1
"""Interval of looking whether a viewer has started [s]."""
_MAGIC = b"RRF2"


def open_in_viewer(
    recording: Path, *, web: bool, say: Callable[[str], None], at: float | None = None
) -> int:
    """Show a recording until a person ends it; returns the viewer's exit code.

    Args:
        recording: the file.
        web: in the browser instead of a window.
        say: receives the address of the page.
        at: the moment to show first [s]; None for the beginning.

    Raises:
        ViewError: there is no recording, or no screen for a window.
        WebFilesError: there is no viewer.
    """
    _check(recording)
    if at is not None and (web or not has_screen()):
        raise ViewError(
            "--at needs a window: a viewer in the browser cannot be told the moment; leave it out"
        )
    if web:
        return _serve(recording, say)
    if not has_screen():
        raise ViewError("there is no screen here; --web shows the recording in a browser")
    data = Address()
    command = [str(viewer_program()), "--bind", data.host, "--port", str(data.port), str(recording)]
    if at is not None:
        return _at_moment(command, data.url, at)
    os.execve(command[0], command, viewer_environment())


def _at_moment(command: Sequence[str], url: str, at: float) -> int:
    """Run a viewer and set it to a moment [s]; its exit code."""
    with subprocess.Popen(command, env=viewer_environment()) as viewer:
        try:
            _go_to(url, at, while_there=lambda: viewer.poll() is None)
            return viewer.wait()
        except KeyboardInterrupt:  # the viewer has it as well
            return viewer.wait()


def _serve(recording: Path, say: Callable[[str], None]) -> int:
    viewer_web_files()
    files = FileServer(LOOPBACK, choose_port(usual=USUAL_WEB_PORT), recording=recording)
    origin = f"http://{LOOPBACK}:{files.port}"
    with until_interrupted():
        say(f"watch at {origin}/{viewer_address(f'{origin}/{RECORDING}')}; Ctrl-C ends it")
    files.close()
    return 0


def _go_to(url: str, at: float, while_there: Callable[[], bool]) -> None:
    from rerun.experimental import ViewerClient

    while while_there():
        try:
            client = ViewerClient.connect(url)
            break
        except Exception:  # Rerun raises many kinds while nobody listens
            threading.Event().wait(_LOOK_PERIOD)
    else:
        return
    show_moment(client, at, while_there)


def show_moment(client: Any, at: float, while_there: Callable[[], bool] = lambda: True) -> None:
    """Pause a viewer at a moment [s] as soon as it has a recording."""
    while while_there() and not client.get_state().recordings:
        threading.Event().wait(_LOOK_PERIOD)
    if while_there():
        client.set_time("t", duration=at, play_state="paused")


def _check(recording: Path) -> None:
    """Raise ViewError for what the viewer could not open."""
    try:
        if not isfile(recording):
            raise ViewError(f"{recording}: the run has no recording; name another")
        with recording.open("rb") as file:
            begins = file.read(len(_MAGIC))
    except OSError as error:
        raise ViewError(
            f"{recording}: cannot be read ({error.strerror}); name another run"
        ) from error
    if begins != _MAGIC:
        raise ViewError(f"{recording}: is not a recording of this version of Rerun; name another")
