"""Makes the pictures of docs/control.md: `python -m app.review.screenshots docs/images`.

One task runs well, and once more with a reflex of the arm while it places. Simulated runs are
reproducible; the moments are found in the log of each run. Each is shown in two sizes of window.
"""

from __future__ import annotations

import threading
from argparse import ArgumentParser
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cv2
import numpy as np

from app.core import RECORDING, RunOptions, parse_fault, run_task
from app.live import HeadlessViewer, headless_viewer
from app.review.event_log import FaultEvent, Log, NodeEvent, read_log
from hw import stopwatch
from trees import shipped

SIZES = ("1600x900", "1280x720")
_TASK, _FAULT = "pick_one", "reflex@lower for 2"

_QUALITY = 70
"""Of the pictures."""
_PATIENCE = 600.0
_ATTEMPTS = 5
_NOTICES = 7.0
"""How long the viewer's own notifications cover a corner of its window [s]."""


@dataclass(frozen=True, kw_only=True)
class Scenes:
    """Two runs, and the moments in them that are worth a picture."""

    run: Path
    faulty: Path

    def moments(self) -> dict[str, tuple[Path, float]]:
        """By name: the folder of a run, and a time on the session's clock [s]."""
        log, faulty = read_log(self.run), read_log(self.faulty)
        fault = next(e.time for e in faulty.events if isinstance(e, FaultEvent) and e.faults)
        return {
            "navigate": (self.run, _part(log, "navigate", 0.5)),
            "grasp": (self.run, _part(log, "grasp", 0.9)),
            "place": (self.run, _part(log, "place", 0.5)),
            "fault": (self.faulty, fault + 0.2),
            "end": (self.run, log.events[-1].time),
        }


def record_scenes(folder: Path) -> Scenes:
    """Run the task twice."""
    options = RunOptions(tree=shipped(_TASK), scene="single", record=folder)
    run = run_task(options).folder
    faulty = RunOptions(
        tree=shipped(_TASK), scene="single", record=folder, faults=(parse_fault(_FAULT),)
    )
    return Scenes(run=run, faulty=run_task(faulty).folder)


def make(folder: Path) -> list[Path]:
    """Make all pictures.

    Returns:
        The files.
    """
    folder.mkdir(parents=True, exist_ok=True)
    made = []
    with TemporaryDirectory() as record:
        moments = record_scenes(Path(record)).moments()
        for size in SIZES:
            for run in sorted({run for run, _ in moments.values()}):
                with headless_viewer(size=size) as viewer:
                    _open(viewer, run / RECORDING)
                    for name, (of, moment) in moments.items():
                        if of == run:
                            path = folder / f"{name}-{size}.webp"
                            made.append(_save(path, _at(viewer, moment)))
                    if size == SIZES[0] and run == moments["grasp"][0]:
                        views = (("camera", "depth and grasp quality"), ("top-down", "top-down"))
                        for name, view in views:
                            picture = _maximised(viewer, view, moments["grasp"][1])
                            made.append(_save(folder / f"{name}.webp", picture))
    return made


def _part(log: Log, kind: str, share: float) -> float:
    """A moment of the first node of a kind: 0 is its begin, 1 its end [s]."""
    events = [
        event
        for event in log.events
        if isinstance(event, NodeEvent) and log.nodes[event.node].kind == kind
    ]
    begun = next(event.time for event in events if event.status == "RUNNING")
    ended = next(event.time for event in events if event.status != "RUNNING")
    return begun + share * (ended - begun)


def _open(viewer: HeadlessViewer, recording: Path) -> None:
    viewer.client.open(str(recording))
    _until(lambda: viewer.client.get_state().views)
    viewer.client.set_time("t", duration=0.0, play_state="paused")
    threading.Event().wait(_NOTICES)


def _at(viewer: HeadlessViewer, moment: float, view: str | None = None) -> bytes:
    viewer.client.set_time("t", duration=moment, play_state="paused")
    _picture(viewer, view)
    threading.Event().wait(0.5)
    return _picture(viewer, view)


def _maximised(viewer: HeadlessViewer, name: str, moment: float) -> bytes:
    client = viewer.client
    (view,) = (v.view_id for v in client.get_state().views if v.name == name)
    layout = client.get_blueprint().blueprint
    layout["/viewport"]["ViewportBlueprint"]["maximized"] = view
    client.set_blueprint(layout, of="recording")
    return _at(viewer, moment, view)


def _save(path: Path, png: bytes) -> Path:
    picture = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    cv2.imwrite(str(path), picture, [cv2.IMWRITE_WEBP_QUALITY, _QUALITY])
    return path


def _picture(viewer: HeadlessViewer, view: str | None = None) -> bytes:
    """A picture of the viewer or of one view; a busy machine may need several attempts."""
    for _ in range(_ATTEMPTS - 1):
        try:
            return bytes(viewer.client.take_screenshot(view))
        except TimeoutError:
            continue
    return bytes(viewer.client.take_screenshot(view))


def _until(happened: Callable[[], Any]) -> None:
    begun = stopwatch()
    while not happened():
        if stopwatch() - begun > _PATIENCE:
            raise TimeoutError(f"nothing to show within {_PATIENCE:.0f} s")
        threading.Event().wait(0.05)


if __name__ == "__main__":
    arguments = ArgumentParser(description="Make the pictures of docs/control.md.")
    arguments.add_argument("folder", type=Path, nargs="?", default=Path("docs/images"))
    for picture in make(arguments.parse_args().folder):
        print(picture)
