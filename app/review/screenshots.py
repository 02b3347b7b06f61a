"""Makes the pictures of docs/control.md: `python -m app.review.screenshots docs/images`.

One task runs without and once with a fault while it places; the moments are found in the logs.
"""

from __future__ import annotations

import threading
from argparse import ArgumentParser
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cv2
import numpy as np

from app.core import RECORDING, RunOptions, parse_fault, run_task
from app.live import headless_viewer
from app.review.event_log import FaultEvent, Log, NodeEvent, read_log
from app.review.film import screenshot, wait_until
from trees import shipped

SIZES = ("1600x900", "1280x720")
_TASK, _FAULT = "pick_one", "reflex@lower for 2"
_QUALITY = 70
_NOTICES = 7.0
"""Time for which the viewer's own notifications cover a corner of its window [s]."""


def moments(folder: Path) -> dict[str, tuple[Path, float]]:
    """Run the task twice in `folder`; by picture a run and a time on its session's clock [s]."""
    options = RunOptions(tree=shipped(_TASK), scene="single", record=folder)
    run = run_task(options).folder
    faulty = run_task(replace(options, faults=(parse_fault(_FAULT),))).folder
    log, events = read_log(run), read_log(faulty).events
    fault = next(e.time for e in events if isinstance(e, FaultEvent) and e.faults)
    return {
        "navigate": (run, _part(log, "navigate", 0.5)),
        "grasp": (run, _part(log, "grasp", 0.9)),
        "place": (run, _part(log, "place", 0.5)),
        "fault": (faulty, fault + 0.2),
        "end": (run, log.events[-1].time),
    }


def make(folder: Path) -> list[Path]:
    """Make all pictures in a folder, created if missing; returns the files."""
    folder.mkdir(parents=True, exist_ok=True)
    made = []
    with TemporaryDirectory() as record:
        found = moments(Path(record))
        for size in SIZES:
            for run in sorted({run for run, _ in found.values()}):
                with headless_viewer(size=size) as viewer:
                    client = viewer.client
                    client.open(str(run / RECORDING))
                    _begin(client)
                    for name, (of, moment) in found.items():
                        if of == run:
                            path = folder / f"{name}-{size}.webp"
                            made.append(_save(path, _at(client, moment)))
                    if size == SIZES[0] and run == found["grasp"][0]:
                        picture = _maximised(client, "depth and grasp quality", found["grasp"][1])
                        made.append(_save(folder / "camera.webp", picture))
    return made


def _begin(client: Any) -> None:
    """Wait for the recording to be shown without notifications."""
    wait_until(lambda: client.get_state().views)
    client.set_time("t", duration=0.0, play_state="paused")
    threading.Event().wait(_NOTICES)


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


def _at(client: Any, moment: float, view: str | None = None) -> bytes:
    """A picture of the window, or of one view, at a time [s]."""
    client.set_time("t", duration=moment, play_state="paused")
    screenshot(client, view)
    threading.Event().wait(0.5)
    return screenshot(client, view)


def _maximised(client: Any, name: str, moment: float) -> bytes:
    """A picture of one view alone, at a time [s]."""
    (view,) = (v.view_id for v in client.get_state().views if v.name == name)
    layout = client.get_blueprint().blueprint
    layout["/viewport"]["ViewportBlueprint"]["maximized"] = view
    client.set_blueprint(layout, of="recording")
    return _at(client, moment, view)


def _save(path: Path, png: bytes) -> Path:
    picture = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    cv2.imwrite(str(path), picture, [cv2.IMWRITE_WEBP_QUALITY, _QUALITY])
    return path


if __name__ == "__main__":
    arguments = ArgumentParser(description="Make the pictures of docs/control.md.")
    arguments.add_argument("folder", type=Path, nargs="?", default=Path("docs/images"))
    for picture in make(arguments.parse_args().folder):
        print(picture)
