"""Open a recording in the Rerun viewer, in a window or in the browser."""

from __future__ import annotations

import os
from collections.abc import Callable
from os.path import isfile
from pathlib import Path
from typing import NoReturn
from urllib.parse import quote

from app.live.monitor.ports import Address, choose_port
from app.live.monitor.viewer import USUAL_WEB_PORT, ViewError, has_screen, viewer_program

_MAGIC = b"RRF2"
"""Every recording begins with it."""


def open_in_viewer(recording: Path, *, web: bool, say: Callable[[str], None]) -> NoReturn:
    """Show a recording: this process becomes the viewer, and ends with it.

    Args:
        recording: the file.
        web: in the browser instead of a window.
        say: receives the address of the page.

    Raises:
        ViewError: there is no recording there, no viewer, or no screen for a window.
    """
    _check(recording)
    data = Address()
    command = [str(viewer_program()), "--bind", data.host, "--port", str(data.port)]
    if web:
        port = choose_port(usual=USUAL_WEB_PORT)
        command += ["--serve-web", "--web-viewer-port", str(port)]
        page = f"http://{data.host}:{port}/?url={quote(data.url, safe='')}"
        say(f"watch at {page}; Ctrl-C ends it")
    elif not has_screen():
        raise ViewError("there is no screen here; --web shows the recording in a browser")
    os.execv(command[0], [*command, str(recording)])


def _check(recording: Path) -> None:
    """Refuse what the viewer could not open; of what a killed run leaves it shows what there is."""
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
