"""`frankie-task grasp eval`: success rates of the grasps on objects of held-out classes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from math import degrees
from pathlib import Path

import cv2
from rich.table import Table

from lab.grasps.choice import NetworkChoice, all_results
from lab.grasps.closed_loop import OBJECTS, Pick, empty_container, heldout_container
from lab.grasps.cornell import ROOM, CornellImage, matches, read_folder
from lab.grasps.images import CATEGORIES, ImageResult, evaluate_image, evaluation_image
from lab.grasps.picture import overlay, side_by_side
from lab.grasps.step_time import approach, time_steps
from lab.shared import interval, machine, share

_DRAWN = 24  # failures at most


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """All results."""

    network: str
    images: tuple[ImageResult, ...]
    picks: tuple[Pick, ...]
    cornell: tuple[bool, ...]
    step_median_ms: float
    """CPU time from a frame to grasps in the world."""

    def valid(self, category: str) -> list[bool]:
        """For every image of a category, whether its best grasp is valid."""
        return [each.valid for each in self.images if each.category == category]

    @property
    def first_attempt(self) -> list[bool]:
        """For every object, whether it was held at the first attempt."""
        return [pick.held and len(pick.ends) == 1 for pick in self.picks]

    @property
    def within_three(self) -> list[bool]:
        """For every object, whether it was held within three attempts."""
        return [pick.held for pick in self.picks]

    def to_json(self) -> dict[str, object]:
        """For `--json`."""
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


def evaluate_grasps(
    choice: NetworkChoice, *, images: int, objects: int, cornell: Path | None, workers: int
) -> Evaluation:
    """Evaluate a network on images, in the closed loop and on the Cornell data set.

    Args:
        choice: the network.
        images: number of images, half of single objects, half of clutter.
        objects: number of objects to pick in the closed loop, rounded up to whole containers.
        cornell: a folder in the format of the Cornell grasping data set.
        workers: number of processes.

    Raises:
        WeightsError: the weights are missing or do not fit.
        ConfigError: the folder has no readable images.
    """
    detector = choice.detector()
    folder = tuple(read_folder(cornell)) if cornell else ()
    wanted = [(category, seed) for seed in range(-(-images // 2)) for category in CATEGORIES]
    results = all_results(
        "images", partial(_image, choice), wanted[:images], workers, lambda r: r.valid
    )
    containers = range(-(-objects // OBJECTS))
    emptied = all_results(
        "containers",
        partial(_container, choice),
        containers,
        workers,
        lambda picks: all(pick.held for pick in picks),
    )
    return Evaluation(
        network=choice.name,
        images=tuple(results),
        picks=tuple(pick for picks in emptied for pick in picks),
        cornell=tuple(
            all_results("Cornell", partial(_rectangles, choice), folder, workers, lambda good: good)
        ),
        step_median_ms=time_steps({"": detector}, approach(20))[0].median,
    )


def _image(choice: NetworkChoice, item: tuple[str, int]) -> ImageResult:
    category, seed = item
    return evaluate_image(choice.detector(), seed, category)


def _container(choice: NetworkChoice, seed: int) -> list[Pick]:
    return empty_container(heldout_container(seed), choice.detector(), seed)


def _rectangles(choice: NetworkChoice, image: CornellImage) -> bool:
    from perception.networks import read_metadata

    weights = choice.weights
    published = weights is not None and "recipe" not in read_metadata(weights)
    room = 0.0 if published else ROOM  # published networks were trained on such rectangles
    return matches(choice.detector().proposer, image, room=room)


def _groups(images: Iterable[ImageResult]) -> dict[str, dict[str, list[bool]]]:
    """Validity of the grasps, grouped by properties of the image."""
    groups: dict[str, dict[str, list[bool]]] = {
        "camera height": {},
        "tilt": {},
        "noise": {},
        "class": {},
    }
    for each in sorted(images, key=lambda each: (each.height, each.target_class)):
        labels = {
            "camera height": f"{0.1 * int(10 * each.height):.1f} m",
            "tilt": f"to {5 * int(degrees(each.tilt) / 5) + 5:2d}°",
            "noise": ("low", "middle", "high")[min(int(3 * each.noise_level), 2)],
            "class": each.target_class or "none found",
        }
        for name, label in labels.items():
            groups[name].setdefault(label, []).append(each.valid)
    return {name: dict(sorted(found.items())) for name, found in groups.items()}


def evaluation_table(evaluation: Evaluation) -> Table:
    """All shares with their confidence intervals."""
    shown = Table("measured", "good", "of", "share", "95 % interval", title=evaluation.network)
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


def draw_failures(choice: NetworkChoice, evaluation: Evaluation, out: Path) -> int:
    """Draw images whose best grasp fails, side by side; returns their number."""
    failed = [each for each in evaluation.images if not each.valid][:_DRAWN]
    pictures = []
    for each in failed:
        image = evaluation_image(each.seed, each.category)
        frame = image.frame
        detection = choice.detector().detect(frame, image.region)
        caption = f"{each.category} {each.seed}, {each.target_class}: {each.end}"
        pictures.append(overlay(frame.depth, frame.intrinsics, detection, caption))
    if pictures:
        cv2.imwrite(str(out), side_by_side(pictures))
    return len(pictures)
