"""Film of a recorded run: `frankie-task film RUN run.webp`.

The viewer shows the recording without a window; it needs a Vulkan driver, see `headless_viewer`.
Pillow, which comes with Rerun, writes the film.
"""

import threading
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from app.live import ViewError, check_recording, headless_viewer
from config import UserError
from hw import stopwatch

_VIEWS = ("tree", "scene")
_SIZE = "1920x1080"
_WIDTH = 960  # of the film [px]
_SPEED, _RATE = 2.5, 10.0  # recorded seconds per second, and pictures per second
_NOTICES = 8.0  # time for which the viewer's own notifications cover a corner of its window [s]
_PATIENCE = 60.0
_ATTEMPTS = 5
_LAST = 1.5  # duration of the last picture [s]


def make_film(recording: Path, out: Path, begin: float, end: float) -> int:
    """Make a film of a recording from `begin` to `end` [s]; returns the number of pictures.

    Raises UserError: the file is no .webp or cannot be written, or `end` is before `begin`;
    ViewError: the viewer does not start, or has nothing to show.
    """
    if out.suffix != ".webp":
        raise UserError(f"{out}: a film ends in .webp")
    if not 0.0 <= begin < end:
        raise UserError(f"from {begin:g} s to {end:g} s is no time; give --from and --to")
    check_recording(recording)
    pictures = []
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
            pictures.append(_side_by_side([_screenshot(client, view) for view in views]))
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


def _side_by_side(pngs: Sequence[bytes]) -> Any:
    """Pictures of the same height beside each other."""
    from PIL import Image

    pictures = [Image.open(BytesIO(png)).convert("RGB") for png in pngs]
    shares = [one.width / one.height for one in pictures]
    height = round(_WIDTH / sum(shares))
    sheet = Image.new("RGB", (_WIDTH, height))
    left = 0.0
    for picture, share in zip(pictures, shares, strict=True):
        sheet.paste(picture.resize((round(share * height), height)), (round(left), 0))
        left += share * height
    return sheet
