"""Where the images of an emulated camera come from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from hw.clock import Clock, WallClock, stopwatch
from hw.frame import DepthFrame, DepthImage
from hw.robot import DepthCamera
from hw.sim import kinematic_robot, load_scene
from robots import load_robot


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
    return _shots(camera.latest, clock)


def of_scene(scene: str, seed: int = 0) -> Source:
    """What a robot sees that stands in a simulated scene, in its ready posture.

    Args:
        scene: a shipped scene or a scene file.
        seed: of its objects and of the noise.

    Raises:
        UserError: there is no such scene, or its file has a mistake.
    """
    description, clock = load_robot("frankie"), WallClock()
    world = load_scene(scene, seed, description.base.size[:2])
    camera = kinematic_robot(description, world, clock, seed=seed).camera
    return _shots(lambda: camera.latest(inf), clock)


def still(depth: npt.NDArray[np.float32], infrared: npt.NDArray[np.uint8] | None = None) -> Source:
    """One image again and again, captured anew each time."""
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
