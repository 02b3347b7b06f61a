"""Film of a recorded run: scene, camera, and what runs. `frankie-task film RUN run.webp`.

The viewer shows the recording without a window; it needs a Vulkan driver, see `headless_viewer`.
Pillow, which comes with Rerun, writes the film.
"""

import threading
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np

from app.live import ViewError, check_recording
from app.review import Log, NodeEvent, NowEvent, Timeline, read_log, timeline
from config import UserError
from hw import stopwatch
from lab.film.headless_viewer import headless_viewer

_VIEWS = ("scene", "depth and grasp quality")
_SIZE = "1920x1080"
_SCENE, _SIDE = (620, 418), (332, 249)  # width and height of scene and camera [px]
_GAP = 8  # between the panes [px]
_TEXT, _LINE, _LONGEST = 21, 27, 29  # height of letters and lines [px], characters in a line
_GROUND, _EDGE, _BRIGHT, _DIM = (24, 26, 31), (58, 64, 74), (240, 242, 245), (150, 156, 166)
_SPEED, _RATE = 2.5, 10.0  # recorded seconds per second, and pictures per second
_NOTICES = 8.0  # time for which the viewer's own notifications cover a corner of its window [s]
_PATIENCE = 60.0
_ATTEMPTS = 5
_LAST = 1.5  # duration of the last picture [s]


def make_film(recording: Path, out: Path, begin: float, end: float) -> int:
    """Make a film of a recording from `begin` to `end` [s]; returns the number of pictures.

    Raises UserError: the file is no .webp or cannot be written, `end` is before `begin`, or the run
    has no event log; ViewError: the viewer does not start, or has nothing to show.
    """
    if out.suffix != ".webp":
        raise UserError(f"{out}: a film ends in .webp")
    if not 0.0 <= begin < end:
        raise UserError(f"from {begin:g} s to {end:g} s is no time; give --from and --to")
    check_recording(recording)
    log = read_log(recording.parent)
    run, pictures = timeline(log), []
    with headless_viewer(size=_SIZE) as viewer:
        client = viewer.client
        client.open(str(recording))
        views = _shown_views(client)
        try:
            client.set_time("t", duration=float(begin), play_state="paused")
        except ConnectionError:
            raise ViewError(f"{recording}: nothing happened in the run; name another") from None
        threading.Event().wait(_NOTICES)
        for moment in np.arange(begin, end, _SPEED / _RATE):
            client.set_time("t", duration=float(moment), play_state="paused")
            pngs = [_screenshot(client, view) for view in views]
            pictures.append(_sheet(pngs, _what_runs(log, run, float(moment))))
    shown = [round(1000.0 / _RATE)] * (len(pictures) - 1) + [round(1000.0 * _LAST)]
    first, *others = pictures
    try:
        first.save(
            out, save_all=True, append_images=others, duration=shown, loop=0, quality=55, method=6
        )
    except OSError as error:
        raise UserError(f"{out}: cannot be written ({error.strerror or error})") from error
    return len(pictures)


def _shown_views(client: Any) -> list[str]:
    """The viewer's names of the views of a film; raises ViewError if none appears in time."""
    begun = stopwatch()
    while not (views := client.get_state().views):
        if stopwatch() - begun > _PATIENCE:
            raise ViewError(f"the viewer shows nothing within {_PATIENCE:.0f} s")
        threading.Event().wait(0.05)
    found = {view.name: view.view_id for view in views}
    return [found[name] for name in _VIEWS if name in found]


def _screenshot(client: Any, view: str) -> bytes:
    """PNG of a view; a busy machine may need several attempts."""
    for _ in range(_ATTEMPTS - 1):
        try:
            return bytes(client.take_screenshot(view))
        except TimeoutError:
            continue
    return bytes(client.take_screenshot(view))


def _what_runs(log: Log, run: Timeline, time: float) -> list[str]:
    """The running nodes that have a name of their own, the leaf, and its message."""
    leaf = run.leaf_at(time)
    if leaf is None:
        return []
    names, above = [run.nodes[leaf].name], run.parents[leaf]
    while above is not None:
        node, above = run.nodes[above], run.parents[above]
        if node.name != node.kind:
            names.insert(0, node.name)
    said = [
        event.message
        for event in log.events
        if isinstance(event, NodeEvent | NowEvent) and event.node == leaf and event.time <= time
    ]
    return [*names, said[-1] if said else ""]


def _sheet(pngs: Sequence[bytes], words: Sequence[str]) -> Any:
    """The scene, and beside it what the camera sees above what runs."""
    from PIL import Image, ImageDraw, ImageFont, ImageOps

    left, height = _SCENE[0] + _GAP, _SCENE[1]
    sheet = Image.new("RGB", (left + _SIDE[0], height), _GROUND)
    for png, size, at in zip(pngs, (_SCENE, _SIDE), (0, left), strict=False):
        picture = Image.open(BytesIO(png)).convert("RGB")
        sheet.paste(ImageOps.fit(picture, size), (at, 0))
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(_TEXT)
    draw.rectangle((left, 0, sheet.width - 1, _SIDE[1] - 1), outline=_EDGE)
    *names, message = words or [""]
    lines = [(_DIM, name) for name in names[:-1]] + [(_BRIGHT, name) for name in names[-1:]]
    lines += [(_DIM, line) for line in wrap(message, _LONGEST)[:2]]
    for row, (colour, line) in enumerate(lines):
        draw.text((left + _GAP, _SIDE[1] + _GAP + row * _LINE), line, colour, font)
    return sheet
