"""Open a recording in the Rerun viewer, in a window or in the browser."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn
from urllib.parse import quote

from app.live.monitor.viewer import LOOPBACK, USUAL_WEB_PORT, Address, ViewError, viewer_program


def replay(recording: Path, *, web: bool, say: Callable[[str], None]) -> NoReturn:
    """Show a recording: this process becomes the viewer, and ends with it.

    Args:
        recording: the file.
        web: in the browser instead of a window.
        say: told where to look.

    Raises:
        ViewError: there is no recording, no viewer, or no screen for a window.
    """
    if not recording.is_file():
        raise ViewError(f"{recording}: the run has no recording")
    data = Address(host=LOOPBACK, port=_free_port(0))
    command = [str(viewer_program()), "--bind", data.host, "--port", str(data.port)]
    if web:
        port = _free_port(USUAL_WEB_PORT)
        command += ["--serve-web", "--web-viewer-port", str(port)]
        page = f"http://{LOOPBACK}:{port}/?url={quote(data.url, safe='')}"
        say(f"watch at {page}; Ctrl-C ends it")
    elif not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise ViewError("there is no screen here; --web shows the recording in a browser")
    os.execv(command[0], [*command, str(recording)])


def _free_port(usual: int) -> int:
    """The usual port, or any other that is free."""
    for port in (usual, 0):
        with socket.socket() as probe:
            try:
                probe.bind((LOOPBACK, port))
            except OSError:
                continue
            return int(probe.getsockname()[1])
    raise ViewError(f"no port is free on {LOOPBACK}")
