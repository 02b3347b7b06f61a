"""CPU time of a perception step, from a frame of the wrist camera to grasps in the world.

Every detector gets every frame, in a random order, on one thread. Times are CPU times of the
thread, which other processes do not affect.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from inspect import getmodule
from time import thread_time_ns
from typing import Any

import cv2
import numpy as np
from pinocchio import SE3
from rich.table import Table

from behaviours import Region
from hw import DepthFrame
from hw.sim import D435Noise, Hand, load_scene
from lab.grasps.scenes import ROBOT, noisy_frame
from lab.shared import Functions, PartTimer
from perception import GraspDetector

_ROUNDS = 3
_CONTAINER = Region(  # of the scene `household`, its inside
    name="container",
    wTr=SE3(np.eye(3), np.array([3.0, 0.0, 0.556])),
    size=np.array([0.44, 0.36, 0.20]),
)


def _parts() -> Functions:
    """The functions that a step consists of, where the detector looks them up."""
    from perception.networks import Proposer

    detector = getmodule(GraspDetector)
    assert detector is not None
    return {
        "prepare": ((detector, "prepare"),),
        "height map": ((detector, "local_heights"),),
        "network": ((Proposer, "infer"),),
        "candidates": ((Proposer, "propose"),),
        "refine": ((detector.GraspRanking, "among"),),
    }


@dataclass(frozen=True, kw_only=True)
class StepTimes:
    """CPU time of the steps of one detector [ms]."""

    name: str
    steps: int
    median: float
    p95: float
    worst: float


@dataclass(frozen=True, kw_only=True)
class PerceptionResult:
    """Times of all detectors; the first is the default."""

    times: tuple[StepTimes, ...]
    parts: Mapping[str, float]  # median times of the parts of the default's step [ms]

    @property
    def ratios(self) -> dict[str, float]:
        """Medians of the others over the default's."""
        first, *others = self.times
        return {f"{other.name} / {first.name}": other.median / first.median for other in others}


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


def _detectors() -> dict[str, GraspDetector]:
    """Every shipped network in its inference form and layer by layer as written."""
    from perception.networks import NETWORKS, Proposer, shipped_network

    proposers = [
        Proposer(shipped_network(name), plain=plain) for name in NETWORKS for plain in (False, True)
    ]
    return {
        proposer.name: GraspDetector(proposer=proposer, gripper=ROBOT.gripper)
        for proposer in proposers
    }


def _time_steps(
    detectors: Mapping[str, GraspDetector], frames: Sequence[DepthFrame]
) -> tuple[StepTimes, ...]:
    """Times of all detectors on the same frames."""
    import torch

    cv2.setNumThreads(1)
    torch.set_num_threads(1)
    rng = np.random.default_rng(0)
    names = list(detectors)
    spent: dict[str, list[int]] = {name: [] for name in names}
    for name in names:
        detectors[name].detect(frames[0], _CONTAINER)  # warm-up
    for frame in [*frames] * _ROUNDS:
        for index in rng.permutation(len(names)):
            name = names[index]
            begun = thread_time_ns()
            detectors[name].detect(frame, _CONTAINER)
            spent[name].append(thread_time_ns() - begun)
    times = []
    for name, all_of in spent.items():
        median, p95, worst = (np.percentile(all_of, (50.0, 95.0, 100.0)) / 1e6).tolist()
        times.append(StepTimes(name=name, steps=len(all_of), median=median, p95=p95, worst=worst))
    return tuple(times)


def measure_perception(frames: int) -> PerceptionResult:
    """Times of all shipped networks, and of the parts of the default's step."""
    seen, detectors = _approach(frames), _detectors()
    times = _time_steps(detectors, seen)
    timer = PartTimer(_parts())
    default = next(iter(detectors.values()))
    with timer.measuring():
        for frame in seen:
            timer.step(lambda frame=frame: default.detect(frame, _CONTAINER))  # type: ignore[misc]
    parts = {name: 1e-3 * median for name, median in timer.medians().items()}
    return PerceptionResult(times=times, parts=parts)


def perception_table(result: PerceptionResult) -> Table:
    """CPU times of whole steps."""
    shown = Table("step", "median", "p95", "worst", title="perception, ms of one core")
    for each in result.times:
        shown.add_row(each.name, f"{each.median:.1f}", f"{each.p95:.1f}", f"{each.worst:.1f}")
    return shown


def perception_notes(result: PerceptionResult) -> list[str]:
    """Times of the parts, and ratios."""
    parts = ", ".join(f"{name} {time:.1f}" for name, time in result.parts.items())
    ratios = [f"{name}: {ratio:.1f}" for name, ratio in result.ratios.items()]
    return [f"{result.times[0].name}, ms: {parts}", *ratios]


def perception_figures(result: PerceptionResult) -> dict[str, Any]:
    """All times, for JSON."""
    return {
        "times_ms": [asdict(each) for each in result.times],
        "ratios": result.ratios,
        "parts_ms": dict(result.parts),
    }
