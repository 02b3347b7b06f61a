"""An emulated camera and the driver on it, in real time."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
from waiting import until

from drivers.realsense import RealSenseCamera, RealSenseSettings, missing
from extensions.emulators.realsense import Options, RealSenseEmulator, Shot, still
from hw import WallClock
from hw.clock import stopwatch
from robots import load_robot

D435 = load_robot("frankie").camera
needs_library = pytest.mark.skipif(bool(missing()), reason=missing())


def picture() -> np.ndarray:
    """Depth in whole millimetres with something else at every pixel, and some missing."""
    v, u = np.mgrid[:480, :640]
    depth = ((500 + (u + 3 * v) % 1999) / 1000.0).astype(np.float32)
    depth[100:140, 200:260] = np.nan
    return depth


class Counting:
    """A source whose images say which they are, and that notes when they were taken."""

    def __init__(self) -> None:
        self.stamps: list[float] = []

    def __call__(self) -> Shot:
        stamp = stopwatch()
        self.stamps.append(stamp)
        depth = np.full((480, 640), 0.5 + len(self.stamps) / 1000.0, np.float32)
        return Shot(depth=depth, stamp=stamp)

    def number(self, depth: np.ndarray) -> int:
        """Which image that is, from 0."""
        return round((float(depth[0, 0]) - 0.5) * 1000.0) - 1


@contextmanager
def plugged_in(
    source: Any = None,
    options: Options | None = None,
    as_reported: tuple[str, ...] = (),
    **settings: Any,
) -> Iterator[tuple[RealSenseEmulator, RealSenseCamera, WallClock]]:
    """A connected camera."""
    clock = WallClock()
    source = source or still(picture())
    with RealSenseEmulator(source, options, as_reported) as emulator:
        told = RealSenseSettings(emulator=emulator.address, **settings)
        camera = RealSenseCamera(D435, clock, told)
        camera.connect()
        try:
            yield emulator, camera, clock
        finally:
            camera.close()


def new_images(camera: RealSenseCamera, count: int) -> list[Any]:
    """The next images."""
    images = [camera.latest()]
    while len(images) < count:
        until(lambda: camera.latest() is not images[-1])
        images.append(camera.latest())
    return images
