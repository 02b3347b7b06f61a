"""Opens a recording in the Rerun viewer, in a window or in the browser."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from app.live.viewer.viewer import USUAL_WEB_PORT, ViewError, has_screen
from app.live.web import (
    FileServer,
    viewer_address,
    viewer_environment,
    viewer_program,
    viewer_web_files,
)
from app.live.web.http_server import RECORDING
from app.live.web.ports import LOOPBACK, choose_port
from app.terminal import until_interrupted

_MAGIC = b"RRF2"


def open_in_viewer(recording: Path, *, web: bool, say: Callable[[str], None]) -> None:
    """Show a recording until a person ends it, in the browser or in a window.

    `say` receives the address of the page; a window takes the place of this process.

    Raises:
        ViewError: there is no recording, or no screen for a window.
        WebFilesError: there is no viewer.
    """
    _check(recording)
    if web:
        viewer_web_files()
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


def _check(recording: Path) -> None:
    """Raise ViewError for what the viewer could not open."""
    try:
        if not recording.is_file():
            raise ViewError(f"{recording}: the run has no recording; name another")
        with recording.open("rb") as file:
            begins = file.read(len(_MAGIC))
    except OSError as error:
        raise ViewError(
            f"{recording}: cannot be read ({error.strerror}); name another run"
        ) from error
    if begins != _MAGIC:
        raise ViewError(f"{recording}: is not a recording of this version of Rerun; name another")
