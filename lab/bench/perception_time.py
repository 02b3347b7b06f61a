"""Time of a perception step, from a frame of the wrist camera to grasps, on one thread."""

from collections.abc import Callable, Sequence
from functools import partial

import cv2
import numpy as np
from pinocchio import SE3
from rich.table import Table

from behaviours import Region
from hw import DepthFrame
from hw.sim import D435Noise, Hand, load_scene
from lab.bench.timing import Interleaved, Timing
from lab.grasps import ROBOT, noisy_frame
from lab.shared import fixed, machine, table
from perception import GraspDetector, load_ggcnn

_ROUNDS = 3
_CONTAINER = Region(  # of the scene `household`, its inside
    name="container",
    mTr=SE3(np.eye(3), np.array([3.0, 0.0, 0.556])),
    size=np.array([0.44, 0.36, 0.20]),
)


def time_perception(frames: int) -> list[Timing]:
    """Time a whole step, and GG-CNN alone, in all cells of an image."""
    cv2.setNumThreads(1)
    network, detector = load_ggcnn(), GraspDetector.shipped(ROBOT.gripper)
    image = np.zeros((300, 300), dtype=np.float32)
    works: dict[str, Callable[[], object]] = {"ggcnn": partial(network.infer, image)}
    seen, timer = _approach(frames), Interleaved(0)
    for frame in [seen[0], *seen * _ROUNDS]:
        works["step"] = partial(detector.detect, frame, _CONTAINER)
        timer(works)
    return timer.timings(works)


def perception_table(timings: Sequence[Timing]) -> Table:
    """One row for each part."""
    return table(
        f"Processor time in µs, on {machine()['machine']}",
        timings,
        {"": lambda one: one.name},
        {
            "steps": lambda one: one.steps,
            "median": lambda one: fixed(one.median, 0),
            "p99": lambda one: fixed(one.p99, 0),
        },
        title_justify="left",
    )


def _approach(frames: int) -> list[DepthFrame]:
    """Noisy frames of the wrist camera, with the open hand in it, on its way into a container."""
    world = load_scene("household", 0)
    rng, noise = np.random.default_rng(0), D435Noise()
    seen = []
    for height in np.linspace(0.85, 0.68, frames):
        wTe = SE3(np.diag([1.0, -1.0, -1.0]), np.array([2.94, 0.02, height]))
        hand = Hand(ROBOT.gripper, wTe).shapes(ROBOT.gripper.opening)
        shapes = [*world.shapes(), *hand]
        seen.append(noisy_frame(shapes, wTe * ROBOT.camera.eTc, noise, rng))
    return seen
