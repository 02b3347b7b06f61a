"""Sources of images for an emulated camera."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from hw.clock import Clock, WallClock, stopwatch
from hw.robot import DepthCamera
from hw.sim import kinematic_robot, load_scene
from hw.state import DepthFrame, DepthImage
from robots import load_robot


@dataclass(frozen=True, kw_only=True, eq=False)
class Shot:
    """One image of a source."""

    depth: npt.NDArray[np.float32]  # (H, W) depth along the optical axis [m]; NaN where missing
    stamp: float  # capture time, of `stopwatch` [s]
    infrared: npt.NDArray[np.uint8] | None = None  # (H, W) brightness; None without infrared


Source: TypeAlias = Callable[[], Shot | None]
"""The current image, called once a period; None if there is none. An object is sent once."""


def of_camera(camera: DepthCamera, clock: Clock) -> Source:
    """The images of a (simulated) camera that stamps with a real-time clock."""
    return _shots(camera.latest, clock)


def of_scene(scene: str, seed: int = 0) -> Source:
    """The view of a robot in its ready posture in a simulated scene.

    Raises:
        UserError: the scene is unknown or its file is wrong.
    """
    description, clock = load_robot("frankie"), WallClock()
    world = load_scene(scene, seed, description.base.size[:2])
    camera = kinematic_robot(description, world, clock, seed=seed).camera
    return _shots(lambda: camera.latest(inf), clock)


def still(depth: npt.NDArray[np.float32], infrared: npt.NDArray[np.uint8] | None = None) -> Source:
    """The same image again and again, with new stamps."""
    return lambda: Shot(depth=depth, stamp=stopwatch(), infrared=infrared)


def _shots(latest: Callable[[], DepthImage | DepthFrame | None], clock: Clock) -> Source:
    last: tuple[object, Shot] | None = None

    def shoot() -> Shot | None:
        nonlocal last
        image = latest()
        if image is None:
            return None
        if last is None or image is not last[0]:
            age = clock.now() - image.stamp
            last = image, Shot(depth=image.depth, stamp=stopwatch() - age)
        return last[1]

    return shoot
