"""Sources of images for an emulated camera."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from config.arrays import Image
from hw import WallClock, stopwatch
from hw.sim import kinematic_robot, load_scene
from robots import load_robot


@dataclass(frozen=True, kw_only=True, eq=False)
class Shot:
    """One image of a source."""

    depth: Image  # (H, W) depth along the optical axis [m]; NaN where missing
    stamp: float  # capture time, of `stopwatch` [s]
    infrared: npt.NDArray[np.uint8] | None = None  # (H, W) brightness; None without infrared


Source: TypeAlias = Callable[[], Shot | None]  # called once a period; None: no image


def of_scene(scene: str, seed: int = 0) -> Source:
    """The view of a robot in its ready posture in a simulated scene, which may raise UserError."""
    description, clock = load_robot("frankie"), WallClock()
    world = load_scene(scene, seed, description.base.size[:2])
    camera = kinematic_robot(description, world, clock, seed=seed).camera
    last: tuple[object, Shot] | None = None

    def shoot() -> Shot | None:
        nonlocal last
        frame = camera.latest(inf)
        if frame is None:
            return None
        if last is None or frame is not last[0]:
            age = clock.now() - frame.stamp
            last = frame, Shot(depth=frame.depth, stamp=stopwatch() - age)
        return last[1]

    return shoot


def still(depth: Image, infrared: npt.NDArray[np.uint8] | None = None) -> Source:
    """The same image again and again, with new stamps."""
    return lambda: Shot(depth=depth, stamp=stopwatch(), infrared=infrared)
