"""Makes the pictures of docs/watching.md: `python -m app.review.screenshots docs/images`.

The first shows a live run, the others the recording that it leaves. Simulated runs are
reproducible, so the moments are fixed.
"""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from app.core import RECORDING
from app.live import Address, HeadlessViewer, headless_viewer
from hw import stopwatch

GRASPING = 20.3
"""The hand descends to the second object [s]."""
CARRYING = 23.0
"""The robot is on its way to the table [s]."""

_PATIENCE = 600.0
_ATTEMPTS = 5
_NOTICES = 8.0
"""How long the viewer's own notifications cover a corner of its window [s]."""


def make(folder: Path) -> list[Path]:
    """Make all pictures.

    Args:
        folder: for the pictures; created if missing.

    Returns:
        The files.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as record:
        made = [_live(folder / "watching.png", Path(record))]
        (recording,) = Path(record).glob(f"*/{RECORDING}")
        with headless_viewer() as viewer:
            viewer.client.open(str(recording))
            _until(lambda: viewer.client.get_state().views)
            for name, view, moment in (
                ("scene", "scene", GRASPING),
                ("top-down", "top-down", CARRYING),
                ("camera", "depth and grasp quality", GRASPING),
            ):
                made.append(_maximised(viewer, folder / f"{name}.png", view, moment))
    return made


def _live(path: Path, record: Path) -> Path:
    """The whole viewer while a task runs; then stop the run."""
    server = Address()
    command = [
        sys.executable,
        "-m",
        "frankie_task_cli",
        "run",
        "pick_place",
        "--record",
        str(record),
    ]
    command += ["--view", "web", "--view-port", str(server.port), "--speed", "real"]
    with subprocess.Popen(command) as run:
        try:
            _until(lambda: any(record.glob(f"*/{RECORDING}")))
            with headless_viewer(watch=server.url) as viewer:
                _until(lambda: viewer.cursor >= GRASPING)
                path.write_bytes(_picture(viewer))
                _until(lambda: viewer.cursor >= CARRYING)
        finally:
            run.send_signal(signal.SIGINT)
    return path


def _maximised(viewer: HeadlessViewer, path: Path, view: str, moment: float) -> Path:
    """One view alone, at one moment."""
    client = viewer.client
    (view_id,) = (v.view_id for v in client.get_state().views if v.name == view)
    layout = client.get_blueprint().blueprint
    layout["/viewport"]["ViewportBlueprint"]["maximized"] = view_id
    client.set_blueprint(layout, of="recording")
    client.set_time("t", duration=moment, play_state="paused")
    threading.Event().wait(_NOTICES)
    path.write_bytes(_picture(viewer, view_id))
    return path


def _picture(viewer: HeadlessViewer, view_id: str | None = None) -> bytes:
    """A picture of the viewer or of one view; a busy machine may need several attempts."""
    for _ in range(_ATTEMPTS - 1):
        try:
            return bytes(viewer.client.take_screenshot(view_id))
        except TimeoutError:
            continue
    return bytes(viewer.client.take_screenshot(view_id))


def _until(happened: Callable[[], Any]) -> None:
    begun = stopwatch()
    while not happened():
        if stopwatch() - begun > _PATIENCE:
            raise TimeoutError(f"nothing to show within {_PATIENCE:.0f} s")
        threading.Event().wait(0.05)


if __name__ == "__main__":
    for picture in make(Path(sys.argv[1] if len(sys.argv) > 1 else "docs/images")):
        print(picture)
