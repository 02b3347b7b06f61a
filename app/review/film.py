"""Film of a recorded run: `frankie-task film RUN run.webp`.

The viewer shows the recording without a window; it needs a Vulkan driver, see `headless_viewer`.
Pillow, which comes with Rerun, writes the film.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from app.live import ViewError, headless_viewer
from config import UserError
from hw import stopwatch

KINDS = (".webp", ".gif")
VIEWS = ("tree", "scene")
_WINDOW = "1920x1080"
_RATE = 10.0
"""Pictures a second."""
_NOTICES = 8.0
"""Time for which the viewer's own notifications cover a corner of its window [s]."""
_PATIENCE = 60.0
_ATTEMPTS = 5
_LAST = 1.5
"""Duration of the last picture [s]."""


class FilmError(UserError):
    """A film cannot be made."""


def make_film(
    recording: Path,
    out: Path,
    *,
    begin: float,
    end: float,
    speed: float = 2.5,
    width: int = 960,
) -> int:
    """Make a film of a part of a recording; returns the number of pictures.

    It shows the moments from `begin` to `end` [s], `speed` recorded seconds per second, with a
    width in pixels.

    Raises:
        FilmError: the file is no .webp or .gif or cannot be written, or `end` is before `begin`.
        ViewError: the viewer does not start.
    """
    if out.suffix not in KINDS:
        raise FilmError(f"{out}: a film ends in {' or '.join(KINDS)}")
    if not 0.0 <= begin < end:
        raise FilmError(f"from {begin:g} s to {end:g} s is no time; give --from and --to")
    moments = np.arange(begin, end, speed / _RATE)
    pictures = []
    with headless_viewer(size=_WINDOW) as viewer:
        client = viewer.client
        client.open(str(recording))
        wait_until(lambda: client.get_state().views)
        found = {view.name: view.view_id for view in client.get_state().views}
        views = [found[name] for name in VIEWS if name in found]
        client.set_time("t", duration=float(begin), play_state="paused")
        threading.Event().wait(_NOTICES)
        for moment in moments:
            client.set_time("t", duration=float(moment), play_state="paused")
            pictures.append(_side_by_side([screenshot(client, one) for one in views], width))
    _write(out, pictures)
    return len(pictures)


def screenshot(client: Any, view: str | None) -> bytes:
    """PNG of a view, or of the whole window; a busy machine may need several attempts."""
    for _ in range(_ATTEMPTS - 1):
        try:
            return bytes(client.take_screenshot(view))
        except TimeoutError:
            continue
    return bytes(client.take_screenshot(view))


def _side_by_side(pngs: Sequence[bytes], width: int) -> Any:
    """Pictures of the same height beside each other, `width` [px] in all."""
    from PIL import Image

    pictures = [Image.open(BytesIO(png)).convert("RGB") for png in pngs]
    shares = [one.width / one.height for one in pictures]
    height = round(width / sum(shares))
    sheet = Image.new("RGB", (width, height))
    left = 0.0
    for picture, share in zip(pictures, shares, strict=True):
        sheet.paste(picture.resize((round(share * height), height)), (round(left), 0))
        left += share * height
    return sheet


def _write(out: Path, pictures: Sequence[Any]) -> None:
    shown = [round(1000.0 / _RATE)] * (len(pictures) - 1) + [round(1000.0 * _LAST)]
    options = {"quality": 55, "method": 6} if out.suffix == ".webp" else {"optimize": True}
    first, *others = pictures
    try:
        first.save(out, save_all=True, append_images=others, duration=shown, loop=0, **options)
    except OSError as error:
        raise FilmError(f"{out}: cannot be written ({error.strerror or error})") from error


def wait_until(happened: Callable[[], Any]) -> None:
    """Wait until something is true; raises ViewError after a minute."""
    begun = stopwatch()
    while not happened():
        if stopwatch() - begun > _PATIENCE:
            raise ViewError(f"the viewer shows nothing within {_PATIENCE:.0f} s")
        threading.Event().wait(0.05)
