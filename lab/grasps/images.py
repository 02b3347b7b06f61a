"""How often the best grasp in an image is valid, on objects of held-out classes.

A grasp is valid if it succeeds on the exact geometry: the open hand touches nothing on its way
straight down, and the fingers hold what they close on (antipodal within both friction cones, with
its weight carried).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from behaviours import Region
from hw import DepthFrame
from hw.sim import World
from lab.grasps.closed_loop import HELD, execute_grasp
from lab.grasps.scenes import (
    EVALUATION_SEED,
    HELDOUT_CLASSES,
    View,
    class_of,
    clutter_count,
    nearest_object,
    noisy_frame,
    random_view,
    random_world,
)
from perception import GraspDetector

CATEGORIES = ("single", "clutter")
"""One object, or two to ten."""


@dataclass(frozen=True, kw_only=True)
class ImageResult:
    """The result of executing the best grasp in one image."""

    seed: int
    category: str
    """`single` or `clutter`."""
    height: float
    """Of the camera above the floor [m]."""
    tilt: float
    """Of the optical axis from straight down [rad]."""
    noise_level: float
    """0 to 1."""
    end: str
    """`HELD`, or the reason of the failure."""
    target_class: str
    """Of the object nearest to the grasp; empty if no grasp was found."""

    @property
    def valid(self) -> bool:
        """Whether the grasp held."""
        return self.end == HELD


def evaluate_images(
    detector: GraspDetector, category: str, seeds: Iterable[int]
) -> list[ImageResult]:
    """Evaluate the best grasp in one image per seed."""
    return [evaluate_image(detector, seed, category) for seed in seeds]


def valid_rate(results: Sequence[ImageResult]) -> float:
    """Share of the images whose best grasp is valid."""
    return sum(each.valid for each in results) / len(results)


def evaluate_image(detector: GraspDetector, seed: int, category: str) -> ImageResult:
    """Render an image, find its best grasp and execute it."""
    image = evaluation_image(seed, category)
    detection = detector.detect(image.frame, image.region)
    end, target_class = f"no grasp: {detection.reason}", ""
    if detection.grasps:
        best = detection.grasps[0]
        target_class = class_of(nearest_object(image.world, best.wTg.translation))
        end = execute_grasp(image.world, best)
    return ImageResult(
        seed=seed,
        category=category,
        height=image.view.height,
        tilt=image.view.tilt,
        noise_level=image.view.noise_level,
        end=end,
        target_class=target_class,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class EvaluationImage:
    """A rendered image and its scene."""

    world: World
    region: Region
    """In which to grasp."""
    view: View
    frame: DepthFrame


def evaluation_image(seed: int, category: str) -> EvaluationImage:
    """Render the image that seed and category determine."""
    rng = np.random.default_rng((EVALUATION_SEED, CATEGORIES.index(category), seed))
    count = 1 if category == "single" else clutter_count(rng)
    world, region = random_world(rng, HELDOUT_CLASSES, count)
    view = random_view(world, rng)
    frame = noisy_frame(world.shapes(), view.wTc, view.noise, rng)
    return EvaluationImage(world=world, region=region, view=view, frame=frame)
