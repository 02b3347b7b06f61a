"""A recorded run as a moving picture, for a page: `frankie-task film RUN run.webp`.

The viewer shows the recording without a window, moment by moment. It needs a Vulkan driver, as
`app.live.headless_viewer` says; the film itself is written by Pillow, which comes with Rerun.
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
"""Which views of the layout are shown, side by side."""
_WINDOW = "1920x1080"
"""[px]; its views are larger than they become in the film."""

_NOTICES = 8.0
"""How long the viewer's own notifications cover a corner of its window [s]."""
_PATIENCE = 60.0
_ATTEMPTS = 5
_LAST = 1.5
"""How long the last picture stays [s]."""
_QUALITY = 55
"""Of the compression, from 0 to 100."""


class FilmError(UserError):
    """A film cannot be made."""


def make_film(
    recording: Path,
    out: Path,
    *,
    begin: float,
    end: float,
    speed: float = 2.5,
    rate: float = 10.0,
    width: int = 960,
) -> int:
    """Make a film of a part of a recording.

    Args:
        recording: the file.
        out: a .webp or .gif file.
        begin: from when [s].
        end: until when [s].
        speed: how many recorded seconds a second of the film shows.
        rate: pictures a second.
        width: of the film [px].

    Returns:
        Number of pictures.

    Raises:
        FilmError: the file is of another kind or cannot be written, or the times are no time.
        ViewError: the viewer does not start.
    """
    if out.suffix not in KINDS:
        raise FilmError(f"{out}: a film ends in {' or '.join(KINDS)}")
    if not 0.0 <= begin < end:
        raise FilmError(f"from {begin:g} s to {end:g} s is no time; give --from and --to")
    moments = np.arange(begin, end, speed / rate)
    pictures = []
    with headless_viewer(size=_WINDOW) as viewer:
        client = viewer.client
        client.open(str(recording))
        _until(lambda: client.get_state().views)
        found = {view.name: view.view_id for view in client.get_state().views}
        views = [found[name] for name in VIEWS if name in found]
        client.set_time("t", duration=float(begin), play_state="paused")
        threading.Event().wait(_NOTICES)
        for moment in moments:
            client.set_time("t", duration=float(moment), play_state="paused")
            pictures.append(_side_by_side([_picture(client, one) for one in views], width))
    _write(out, pictures, rate)
    return len(pictures)


def _picture(client: Any, view: str) -> Any:
    """A view as it is now; a busy machine may need several attempts."""
    from PIL import Image

    for attempt in range(_ATTEMPTS):
        try:
            return Image.open(BytesIO(client.take_screenshot(view))).convert("RGB")
        except TimeoutError:
            if attempt == _ATTEMPTS - 1:
                raise
    raise AssertionError("unreachable")


def _side_by_side(pictures: Sequence[Any], width: int) -> Any:
    from PIL import Image

    shares = [one.width / one.height for one in pictures]
    height = round(width / sum(shares))
    sheet = Image.new("RGB", (width, height))
    left = 0.0
    for picture, share in zip(pictures, shares, strict=True):
        sheet.paste(picture.resize((round(share * height), height)), (round(left), 0))
        left += share * height
    return sheet


def _write(out: Path, pictures: Sequence[Any], rate: float) -> None:
    shown = [round(1000.0 / rate)] * (len(pictures) - 1) + [round(1000.0 * _LAST)]
    options = {"quality": _QUALITY, "method": 6} if out.suffix == ".webp" else {"optimize": True}
    first, *others = pictures
    try:
        first.save(out, save_all=True, append_images=others, duration=shown, loop=0, **options)
    except OSError as error:
        raise FilmError(f"{out}: cannot be written ({error.strerror or error})") from error


def _until(happened: Callable[[], Any]) -> None:
    begun = stopwatch()
    while not happened():
        if stopwatch() - begun > _PATIENCE:
            raise ViewError(f"the viewer shows nothing within {_PATIENCE:.0f} s")
        threading.Event().wait(0.05)
