"""`frankie-task grasp eval`: how good the grasps are on what was never learnt from, in figures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from math import degrees, sqrt
from pathlib import Path
from typing import TypeVar

import cv2
import torch
from rich.table import Table

from app.lab.grasps.closed_loop import OBJECTS, Pick, empty_container, unseen_container
from app.lab.grasps.cornell import ROOM, CornellImage, matches, read_folder
from app.lab.grasps.images import CATEGORIES, Judged, judge_image, scenery_of
from app.lab.grasps.picture import overlay, side_by_side
from app.lab.grasps.step_time import approach, time_steps
from app.lab.machine import machine
from app.lab.progress import progress
from app.lab.workers import run_all
from perception import GraspDetector
from perception.networks.weights import read_metadata

_DRAWN = 24  # failures at most

Item = TypeVar("Item")
Result = TypeVar("Result")


@dataclass(frozen=True, kw_only=True)
class Proposing:
    """Which network is judged; see `GraspDetector`."""

    weights: Path | None = None
    network: str | None = None

    def detector(self) -> GraspDetector:
        """Ready for use on one thread; made once a process."""
        return _detector(self)


@lru_cache(maxsize=2)
def _detector(proposing: Proposing) -> GraspDetector:
    cv2.setNumThreads(1)
    torch.set_num_threads(1)
    return GraspDetector(proposing.weights, proposing.network)


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """Everything that was measured."""

    network: str
    images: tuple[Judged, ...]
    picks: tuple[Pick, ...]
    cornell: tuple[bool, ...]
    step_median_ms: float
    """Processor time from a frame to grasps in the world."""

    def valid(self, category: str) -> list[bool]:
        """Of every image of a category, whether its best grasp is valid."""
        return [each.valid for each in self.images if each.category == category]

    @property
    def first_attempt(self) -> list[bool]:
        """Of every object, whether the first attempt held it."""
        return [pick.held and len(pick.ends) == 1 for pick in self.picks]

    @property
    def within_three(self) -> list[bool]:
        """Of every object, whether one of three attempts held it."""
        return [pick.held for pick in self.picks]

    def to_json(self) -> dict[str, object]:
        """What `--json` writes."""
        return {
            "network": self.network,
            "images": len(self.images),
            "valid_rate_single": share(self.valid("single")),
            "valid_rate_clutter": share(self.valid("clutter")),
            "objects": len(self.picks),
            "first_attempt_rate": share(self.first_attempt),
            "within_three_rate": share(self.within_three),
            "cornell_images": len(self.cornell),
            "cornell_iou_rate": share(self.cornell),
            "step_median_ms": self.step_median_ms,
            "image_ends": dict(Counter(each.end for each in self.images).most_common()),
            "attempt_ends": dict(
                Counter(end for pick in self.picks for end in pick.ends).most_common()
            ),
            "valid_rate_by": {
                name: {label: share(values) for label, values in groups.items()}
                for name, groups in _groups(self.images).items()
            },
            **machine(),
        }


def evaluate(
    proposing: Proposing, *, images: int, objects: int, cornell: Path | None, workers: int
) -> Evaluation:
    """Measure everything.

    Args:
        proposing: the network.
        images: how many; half of them single objects, half clutter.
        objects: how many to pick in the closed loop, rounded up to whole containers.
        cornell: a folder in the format of the Cornell grasping data set.
        workers: processes.

    Raises:
        WeightsError: the network has no usable weights.
        ConfigError: the folder has no usable images.
    """
    detector = proposing.detector()
    folder = tuple(read_folder(cornell)) if cornell else ()
    wanted = [(category, seed) for seed in range(-(-images // 2)) for category in CATEGORIES]
    judged = _all("images", partial(_image, proposing), wanted[:images], workers, lambda j: j.valid)
    containers = range(-(-objects // OBJECTS))
    emptied = _all(
        "containers",
        partial(_container, proposing),
        containers,
        workers,
        lambda picks: all(pick.held for pick in picks),
    )
    return Evaluation(
        network=str(proposing.weights) if proposing.weights else detector.proposer.name,
        images=tuple(judged),
        picks=tuple(pick for picks in emptied for pick in picks),
        cornell=tuple(
            _all("Cornell", partial(_rectangles, proposing), folder, workers, lambda good: good)
        ),
        step_median_ms=time_steps({"": detector}, approach(20))[0].median,
    )


def _image(proposing: Proposing, item: tuple[str, int]) -> Judged:
    category, seed = item
    return judge_image(proposing.detector(), seed, category)


def _container(proposing: Proposing, seed: int) -> list[Pick]:
    return empty_container(unseen_container(seed), proposing.detector(), seed)


def _rectangles(proposing: Proposing, image: CornellImage) -> bool:
    weights = proposing.weights
    from_elsewhere = weights is not None and "recipe" not in read_metadata(weights)
    room = 0.0 if from_elsewhere else ROOM  # published networks have learnt from such rectangles
    return matches(proposing.detector().proposer, image, room=room)


def _all(
    name: str,
    work: Callable[[Item], Result],
    items: Sequence[Item],
    workers: int,
    good: Callable[[Result], bool],
) -> list[Result]:
    """Results in the order of the items, with a bar."""
    results: dict[int, Result] = {}
    if items:
        with progress(name, len(items)) as advance:
            for number, result in run_all(work, items, workers=workers):
                results[number] = result
                advance(not good(result))
    return [results[number] for number in range(len(items))]


def share(outcomes: Sequence[bool]) -> float | None:
    """Share of good outcomes; None if there are none at all."""
    return sum(outcomes) / len(outcomes) if outcomes else None


def interval(outcomes: Sequence[bool]) -> tuple[float, float]:
    """Limits between which the true share lies in 95 of 100 cases (Wilson, 1927)."""
    n, z = len(outcomes), 1.96
    p = sum(outcomes) / n
    centre = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return max(0.0, centre - half), min(1.0, centre + half)


def _groups(images: Iterable[Judged]) -> dict[str, dict[str, list[bool]]]:
    """Whether grasps are valid, by what may matter."""
    groups: dict[str, dict[str, list[bool]]] = {
        "camera height": {},
        "tilt": {},
        "noise": {},
        "kind": {},
    }
    for each in sorted(images, key=lambda each: (each.height, each.target)):
        labels = {
            "camera height": f"{0.1 * int(10 * each.height):.1f} m",
            "tilt": f"to {5 * int(degrees(each.tilt) / 5) + 5:2d}°",
            "noise": ("low", "middle", "high")[min(int(3 * each.trouble), 2)],
            "kind": each.target or "none found",
        }
        for name, label in labels.items():
            groups[name].setdefault(label, []).append(each.valid)
    return {name: dict(sorted(found.items())) for name, found in groups.items()}


def table(evaluation: Evaluation) -> Table:
    """The figures, each with the interval in which it lies in 95 of 100 cases."""
    shown = Table("measured", "good", "of", "share", "95 of 100", title=evaluation.network)
    rows: list[tuple[str, Sequence[bool]]] = [
        ("best grasp valid, single objects", evaluation.valid("single")),
        ("best grasp valid, clutter", evaluation.valid("clutter")),
        ("held at the first attempt", evaluation.first_attempt),
        ("held within three attempts", evaluation.within_three),
        ("Cornell rectangles", evaluation.cornell),
    ]
    for name, found in _groups(evaluation.images).items():
        rows += [(f"valid, {name} {label}", values) for label, values in found.items()]
    for name, outcomes in rows:
        if outcomes:
            low, high = interval(outcomes)
            shown.add_row(
                name,
                str(sum(outcomes)),
                str(len(outcomes)),
                f"{100 * sum(outcomes) / len(outcomes):.1f} %",
                f"{100 * low:.1f} to {100 * high:.1f} %",
            )
    return shown


def draw_failures(proposing: Proposing, evaluation: Evaluation, out: Path) -> int:
    """Pictures of images whose best grasp fails, side by side; returns how many."""
    failed = [each for each in evaluation.images if not each.valid][:_DRAWN]
    pictures = []
    for each in failed:
        scenery = scenery_of(each.seed, each.category)
        detection = proposing.detector().detect(scenery.frame, scenery.region)
        caption = f"{each.category} {each.seed}, {each.target}: {each.end}"
        frame = scenery.frame
        pictures.append(overlay(frame.depth, frame.intrinsics, detection, caption))
    if pictures:
        cv2.imwrite(str(out), side_by_side(pictures))
    return len(pictures)
