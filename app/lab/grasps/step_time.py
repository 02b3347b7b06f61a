"""How long perception takes, from a frame of the wrist camera to grasps in the world.

Every contender sees every frame, one after the other in an order that is drawn anew, on one thread.
Times are the thread's processor time, which other processes do not lengthen.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from time import thread_time_ns

import cv2
import numpy as np
import torch
from pinocchio import SE3
from rich.table import Table

import perception.detector
from app.lab.grasps.closed_loop import CONTAINER
from app.lab.grasps.scenes import ROBOT
from app.lab.parts import Functions, PartTimer
from hw import DepthFrame
from hw.sim import D435Noise, DepthRenderer, Hand, load_scene
from perception import GraspDetector
from perception.propose import Proposer
from perception.weights import SHIPPED, shipped_network

PARTS: Functions = {
    "prepare": ((perception.detector, "prepare"),),
    "height map": ((perception.detector, "height_map"),),
    "network": ((Proposer, "answer"),),
    "candidates": ((Proposer, "__call__"),),
    "check and refine": ((perception.detector, "refine"),),
}
"""The functions that a step is made of."""

_ROUNDS = 3


@dataclass(frozen=True, kw_only=True)
class StepTimes:
    """Processor time of somebody's steps [ms]."""

    name: str
    steps: int
    median: float
    p95: float
    worst: float


@dataclass(frozen=True, kw_only=True)
class PerceptionResult:
    """Everybody's times; the first is the default."""

    times: tuple[StepTimes, ...]
    parts: Mapping[str, float]
    """Median times of the parts of the default's step [ms]."""

    @property
    def ratios(self) -> dict[str, float]:
        """Medians of the others over the default's."""
        first, *others = self.times
        return {f"{other.name} / {first.name}": other.median / first.median for other in others}


def approach(frames: int) -> list[DepthFrame]:
    """What the wrist camera sees on its way down into a full container, with noise."""
    world = load_scene("household", 0)
    rng, noise = np.random.default_rng(0), D435Noise()
    renderer = DepthRenderer(ROBOT.camera.intrinsics)
    seen = []
    for height in np.linspace(0.85, 0.68, frames):
        wTe = SE3(np.diag([1.0, -1.0, -1.0]), np.array([2.94, 0.02, height]))
        wTc = wTe * ROBOT.camera.eTc
        hand = Hand(ROBOT.gripper, wTe).shapes(ROBOT.gripper.opening)
        depth = renderer.render([*world.shapes(), *hand], wTc)
        depth = noise.apply(depth, ROBOT.camera, rng)
        intrinsics = ROBOT.camera.intrinsics
        seen.append(DepthFrame(depth=depth, intrinsics=intrinsics, wTc=wTc, stamp=0.0))
    return seen


def contenders() -> dict[str, GraspDetector]:
    """Every shipped network as it is used, and layer by layer as it is written."""
    return {
        f"{name}{', plain torch' if plain else ''}": GraspDetector(
            proposer=Proposer(shipped_network(name), plain=plain)
        )
        for name in SHIPPED
        for plain in (False, True)
    }


def time_steps(
    detectors: Mapping[str, GraspDetector], frames: Sequence[DepthFrame]
) -> tuple[StepTimes, ...]:
    """Everybody's times on the same frames."""
    cv2.setNumThreads(1)
    torch.set_num_threads(1)
    rng = np.random.default_rng(0)
    names = list(detectors)
    spent: dict[str, list[int]] = {name: [] for name in names}
    for name in names:
        detectors[name].detect(frames[0], CONTAINER)  # the first time is never like the others
    for frame in [*frames] * _ROUNDS:
        for index in rng.permutation(len(names)):
            name = names[index]
            begun = thread_time_ns()
            detectors[name].detect(frame, CONTAINER)
            spent[name].append(thread_time_ns() - begun)
    result = []
    for name in names:
        median, p95, worst = np.percentile(spent[name], (50.0, 95.0, 100.0)) / 1e6
        result.append(
            StepTimes(
                name=name,
                steps=len(spent[name]),
                median=float(median),
                p95=float(p95),
                worst=float(worst),
            )
        )
    return tuple(result)


def measure_perception(frames: int) -> PerceptionResult:
    """Times of all contenders, and of the parts of the default's step."""
    seen, everybody = approach(frames), contenders()
    times = time_steps(everybody, seen)
    timer = PartTimer(PARTS)
    default = next(iter(everybody.values()))
    with timer.watching():
        for frame in seen:
            timer.step(lambda frame=frame: default.detect(frame, CONTAINER))  # type: ignore[misc]
    parts = {name: 1e-3 * median for name, median in timer.medians().items()}
    return PerceptionResult(times=times, parts=parts)


def perception_table(result: PerceptionResult) -> Table:
    """Processor times of whole steps."""
    shown = Table("step", "median", "p95", "worst", title="perception, ms of one core")
    for each in result.times:
        shown.add_row(each.name, f"{each.median:.1f}", f"{each.p95:.1f}", f"{each.worst:.1f}")
    return shown


def perception_notes(result: PerceptionResult) -> list[str]:
    """The ratios and the parts, a line each."""
    parts = ", ".join(f"{name} {time:.1f}" for name, time in result.parts.items())
    ratios = [f"{name}: {ratio:.1f}" for name, ratio in result.ratios.items()]
    return [f"{result.times[0].name}, ms: {parts}", *ratios]


def perception_json(result: PerceptionResult, about: Mapping[str, str]) -> str:
    """One JSON object: `about` the run, and all times."""
    figures = {
        "times_ms": [asdict(each) for each in result.times],
        "ratios": result.ratios,
        "parts_ms": dict(result.parts),
    }
    return json.dumps({**about, **figures}, indent=2)
