"""Where the images of an emulated camera come from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from hw.clock import Clock, stopwatch
from hw.robot import DepthCamera


@dataclass(frozen=True, kw_only=True, eq=False)
class Shot:
    """One image as its source gives it."""

    depth: npt.NDArray[np.float32]
    """(H, W) depth along the optical axis [m]; NaN where missing."""
    stamp: float
    """When it was captured, of `stopwatch` [s]."""
    infrared: npt.NDArray[np.uint8] | None = None
    """(H, W) brightness; None where the camera has no such image."""


Source: TypeAlias = Callable[[], Shot | None]
"""The image of this moment, asked for once a period; None if there is none. An image that was given
before is not sent again."""


def of_camera(camera: DepthCamera, clock: Clock) -> Source:
    """The images of a camera, for example that of a simulated robot.

    Args:
        camera: whose.
        clock: that it stamps with; it runs in real time.
    """
    last: tuple[object, Shot] | None = None

    def shoot() -> Shot | None:
        nonlocal last
        image = camera.latest()
        if image is None:
            return None
        if last is None or image is not last[0]:
            age = clock.now() - image.stamp
            last = image, Shot(depth=image.depth, stamp=stopwatch() - age)
        return last[1]

    return shoot


def still(depth: npt.NDArray[np.float32], infrared: npt.NDArray[np.uint8] | None = None) -> Source:
    """One image again and again, captured anew each time."""
    return lambda: Shot(depth=depth, stamp=stopwatch(), infrared=infrared)
